// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/contact_table.h"
#include <fmt/format.h>
#include <iterator>

namespace signorini::io {

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
