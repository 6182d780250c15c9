// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/motion_tables.h"
#include <fmt/format.h>
#include <iterator>

namespace signorini::io {

std::string obstacles_header(int dim) {
  return fmt::format("step,time,obstacle,force_x,force_y,{}normal_force,active,min_gap\n",
                     dim == 3 ? "force_z," : "");
}

void add_obstacle_rows(std::string& text, int k, double time, int dim,
                       const std::vector<scene::Contact>& contacts,
                       const diagnostics::ObstacleForces& forces) {
  auto out = std::back_inserter(text);
  for (std::size_t o = 0; o < contacts.size(); ++o) {
    const diagnostics::ObstacleForce& one = forces.each()[o];
    fmt::format_to(out, "{},{:.10g},{}", k, time, contacts[o].name);
    for (std::size_t c = 0; c < static_cast<std::size_t>(dim); ++c)
      fmt::format_to(out, ",{:.17g}", one.force[c]);
    fmt::format_to(out, ",{:.17g},{},{:.17g}\n", one.normal_force, one.active, one.min_gap);
  }
}

std::string probes_header(const std::vector<std::string>& columns) {
  std::string text = "step,time";
  for (const std::string& column : columns)
    text += "," + column;
  return text + "\n";
}

void add_probes_row(std::string& text, int k, double time, std::span<const double> values) {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "{},{:.10g}", k, time);
  for (const double value : values)
    fmt::format_to(out, ",{:.17g}", value);
  text += '\n';
}

} // namespace signorini::io
