#include "io/tables.h"
#include <algorithm>
#include <fmt/format.h>
#include <iterator>

namespace signorini::io {
namespace {

constexpr const char* axes[] = {"x", "y", "z"};

} // namespace

std::string steps_table(const std::vector<forward::StepBalance>& balance, const std::vector<contact::ContactState>& contact,
                        const std::vector<double>& tracking_error, const forward::Scheme& scheme, int dim) {
  std::string text = "step,time,kinetic_energy,elastic_energy,viscous_dissipation,external_work,contact_work,"
                     "energy_residual,";
  for (int c = 0; c < dim; ++c)
    text += fmt::format("contact_force_{},", axes[c]);
  text += tracking_error.empty() ? "active,weak,min_gap,vi_iterations\n"
                                 : "active,weak,min_gap,vi_iterations,tracking_error\n";
  auto out = std::back_inserter(text);
  for (std::size_t k = 0; k < balance.size(); ++k) {
    const forward::StepBalance& b = balance[k];
    const contact::ContactState& state = contact[k];
    fmt::format_to(out, "{},{:.10g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.6e},", k,
                   scheme.time(static_cast<int>(k)), b.kinetic_energy, b.elastic_energy, b.viscous_dissipation,
                   b.external_work, b.contact_work, b.energy_residual);
    for (int c = 0; c < dim; ++c)
      fmt::format_to(out, "{:.17g},", b.contact_force[static_cast<std::size_t>(c)]);
    const int weak = state.count(contact::Status::weak);
    fmt::format_to(out, "{},{},{},{}", state.count(contact::Status::strong) + weak, weak,
                   state.gap.empty() ? "nan" : fmt::format("{:.17g}", std::ranges::min(state.gap)),
                   state.vi_iterations);
    if (!tracking_error.empty())
      fmt::format_to(out, ",{:.17g}", tracking_error[k]);
    text += '\n';
  }
  return text;
}

std::string contact_table(const std::vector<int>& steps, const std::vector<contact::ContactState>& contact,
                          const contact::Constraints& constraints, const forward::Scheme& scheme) {
  const int dim = constraints.dim();
  std::string text = dim == 3 ? "step,time,x,y,z,gap,force\n" : "step,time,x,y,gap,force\n";
  auto out = std::back_inserter(text);
  for (int k : steps) {
    const contact::ContactState& state = contact[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < state.gap.size(); ++i) {
      fmt::format_to(out, "{},{:.10g}", k, scheme.time(k));
      for (int c = 0; c < dim; ++c)
        fmt::format_to(out, ",{:.17g}", constraints.points()[3 * i + static_cast<std::size_t>(c)]);
      fmt::format_to(out, ",{:.17g},{:.17g}\n", state.gap[i], state.lambda[i] / scheme.impulse());
    }
  }
  return text;
}

std::string history_table(const std::vector<HistoryRow>& rows) {
  std::string text = "iteration,objective,tracking,terminal,control_cost,gradient_norm,step_length,forward_sweeps,"
                     "adjoint_sweeps,seconds,relative_distance_to_reference\n";
  auto out = std::back_inserter(text);
  for (const HistoryRow& r : rows)
    fmt::format_to(out, "{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{},{},{:.3f},{:.17g}\n", r.iteration,
                   r.objective, r.tracking, r.terminal, r.control_cost, r.gradient_norm, r.step_length,
                   r.forward_sweeps, r.adjoint_sweeps, r.seconds, r.relative_distance_to_reference);
  return text;
}

} // namespace signorini::io
