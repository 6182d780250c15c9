// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/csv_tables.h"
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>
#include <limits>
#include <sstream>

namespace signorini::io {
namespace {

constexpr const char* axes[] = {"x", "y", "z"};

} // namespace

std::string steps_header(int dim, bool tracking) {
  std::string text = "step,time,kinetic_energy,elastic_energy,viscous_dissipation,external_work,contact_work,"
                     "energy_residual,";
  for (int c = 0; c < dim; ++c)
    text += fmt::format("contact_force_{},", axes[c]);
  return text + fmt::format("active,weak,min_gap,vi_iterations,momentum_residual,complementarity{},"
                            "normal_force,load_work\n",
                            tracking ? ",tracking_error" : "");
}

void add_steps_row(std::string& text, int k, double time, int dim, const diagnostics::StepBalance& balance,
                   const diagnostics::Invariants& invariants, const contact::ContactState& contact,
                   double normal_force, std::optional<double> tracking_error) {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "{},{:.10g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.6e},", k, time,
                 balance.kinetic_energy, balance.elastic_energy, balance.viscous_dissipation,
                 balance.external_work, balance.contact_work, balance.energy_residual);
  for (int c = 0; c < dim; ++c)
    fmt::format_to(out, "{:.17g},", balance.contact_force[static_cast<std::size_t>(c)]);
  const int weak = contact.count(contact::Status::weak);
  const double least =
      contact.gap.empty() ? std::numeric_limits<double>::quiet_NaN() : std::ranges::min(contact.normal_gap());
  fmt::format_to(out, "{},{},{:.17g},{},{:.3e},{:.3e}", contact.count(contact::Status::strong) + weak, weak,
                 least, contact.vi_iterations, invariants.momentum(), invariants.complementarity());
  if (tracking_error)
    fmt::format_to(out, ",{:.17g}", *tracking_error);
  fmt::format_to(out, ",{:.17g},{:.17g}\n", normal_force, balance.load_work);
}

void History::add(const Row& row) {
  const bool first = columns.empty();
  for (const auto& [column, value] : row) {
    if (first)
      columns.push_back(column);
    numbers.push_back(value);
  }
}

double History::at(std::size_t row, const std::string& column) const {
  const auto found = std::ranges::find(columns, column);
  return numbers.at(row * columns.size() + static_cast<std::size_t>(found - columns.begin()));
}

std::string History::table() const {
  std::string all = fmt::format("{}\n", fmt::join(columns, ","));
  for (std::size_t row = 0; row < rows(); ++row)
    all += text(row);
  return all;
}

std::string History::text(std::size_t row) const {
  std::string line;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const double value = numbers[row * columns.size() + c];
    const char* end = c + 1 == columns.size() ? "\n" : ",";
    line +=
        columns[c] == "seconds" ? fmt::format("{:.3f}{}", value, end) : fmt::format("{:.17g}{}", value, end);
  }
  return line;
}

std::vector<std::string> History::split(const std::string& header) {
  std::vector<std::string> names;
  std::istringstream in(header);
  for (std::string name; std::getline(in, name, ',');)
    names.push_back(name);
  return names;
}

} // namespace signorini::io
