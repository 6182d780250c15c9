// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/csv_tables.h"
#include <algorithm>
#include <fmt/format.h>
#include <iterator>

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

void add_steps_row(std::string& text, int k, double time, int dim, const forward::StepBalance& balance,
                   const forward::Invariants& invariants, const contact::ContactState& contact,
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

std::string history_table(const std::vector<HistoryRow>& rows) {
  return "iteration,objective,tracking,terminal,control_cost,gradient_norm,step_length,forward_sweeps,"
         "adjoint_sweeps,seconds,relative_distance_to_reference\n" +
         history_rows(rows);
}

std::string history_rows(const std::vector<HistoryRow>& rows) {
  std::string text;
  auto out = std::back_inserter(text);
  for (const HistoryRow& r : rows)
    fmt::format_to(out, "{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{},{},{:.3f},{:.17g}\n",
                   r.iteration, r.objective, r.tracking, r.terminal, r.control_cost, r.gradient_norm,
                   r.step_length, r.forward_sweeps, r.adjoint_sweeps, r.seconds,
                   r.relative_distance_to_reference);
  return text;
}

} // namespace signorini::io
