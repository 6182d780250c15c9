// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/largest_stress.h"
#include "base/text.h"
#include <fmt/format.h>
#include <utility>

namespace signorini::diagnostics {

LargestStress::LargestStress(const fem::Space& space, std::vector<fem::Part> parts)
    : space_(space), parts_(std::move(parts)) {}

void LargestStress::observe(fem::CellFields& fields, const step::State& state, double t) {
  const double now = fields.largest_von_mises().value;
  if (!(now > largest_))
    return;
  largest_ = now;
  time_ = t;
  if (!state_)
    state_.emplace(state.y(), state.parts().size());
  state_->copy(state);
  peak_.reset();
}

std::optional<LargestStress::Peak> LargestStress::peak() {
  if (!peak_ && state_) {
    fem::CellFields fields(space_, parts_);
    fields.set(state_->y(), state_->v(), state_->q());
    peak_ = {fem::stress_peak(space_, parts_, fields), time_};
  }
  return peak_;
}

std::vector<Warning> LargestStress::warnings() {
  const std::optional<Peak> found = peak();
  if (!found || !(found->stress.largest.value > resolved * found->stress.recovered))
    return {};
  const fem::StressPeak& stress = found->stress;
  const auto place = [&](const std::array<double, 3>& x) {
    return point_text(x.data(), space_.dim()) + " m";
  };
  const double factor = stress.largest.value / stress.recovered;
  std::string text = fmt::format("the largest von Mises stress, {:.4g} Pa in the cell at {}, is {:.3g} times "
                                 "the value recovered from the neighbouring cells (limit {}). This stress "
                                 "depends on the mesh",
                                 stress.largest.value, place(stress.largest.at), factor, resolved);
  if (stress.corner && stress.angle > fem::reentrant)
    text += fmt::format(": with refinement it grows without bound at the corner {}, where the body fills "
                        "{:.2g} of the full angle. Round the corner, or evaluate the stress elsewhere",
                        place(*stress.corner), stress.angle);
  else if (stress.corner)
    text +=
        fmt::format("; use smaller elements at {} to see whether the stress converges. Where a clamp, a load "
                    "or contact ends, the stress does not converge",
                    place(*stress.corner));
  else
    text += "; use smaller elements there to see whether the stress converges";
  return {{stress_of_the_mesh, text, factor, resolved}};
}

} // namespace signorini::diagnostics
