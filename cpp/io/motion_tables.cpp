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

ContactTable::ContactTable(const contact::ContactPairs& pairs, const contact::Pressure& pressure,
                           const std::vector<scene::Contact>& contacts)
    : dim_(pairs.dim()), pressure_(pressure), fixed_(static_cast<std::size_t>(pairs.count())) {
  const auto dim = static_cast<std::size_t>(dim_);
  for (std::size_t i = 0; i < fixed_.size(); ++i) {
    auto point = std::back_inserter(fixed_[i].point), surface = std::back_inserter(fixed_[i].surface);
    fmt::format_to(surface, ",{}", contacts[static_cast<std::size_t>(pairs.obstacles()[i])].name);
    for (std::size_t c = 0; c < dim; ++c) {
      fmt::format_to(point, ",{}", pairs.points()[3 * i + c]);
      fmt::format_to(surface, ",{}", 0 - pairs.normals()[dim * i + c]); // 0 − 0 is no −0
    }
    fmt::format_to(surface, ",{}", pressure.area()[i]);
  }
}

std::string ContactTable::header() const {
  return dim_ == 3 ? "step,time,x,y,z,gap,force,obstacle,normal_x,normal_y,normal_z,area,pressure\n"
                   : "step,time,x,y,gap,force,obstacle,normal_x,normal_y,area,pressure\n";
}

void ContactTable::add_rows(std::string& text, const step::TimeStep& step,
                            const contact::ContactState& contact) const {
  const double impulse = step.scheme().impulse();
  const std::vector<double> pressure = pressure_(contact.normal_lambda(), impulse);
  const std::string when = fmt::format("{},{:.10g}", step.k, step.end);
  auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < fixed_.size(); ++i)
    fmt::format_to(out, "{}{},{},{}{},{}\n", when, fixed_[i].point, contact.gap[i],
                   contact.lambda[i] / impulse, fixed_[i].surface, pressure[i]);
}

} // namespace signorini::io
