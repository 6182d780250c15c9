// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/step_warnings.h"
#include <algorithm>
#include <iterator>

namespace signorini::diagnostics {

StepWarnings::StepWarnings(const step::Stepper& stepper, const scene::Scene& scene,
                           const step::SceneLoad* load, const trajectory::StepErrors* errors)
    : load_(load), passage_(stepper), errors_(errors) {
  if (!errors && stepper.step_lengths())
    errors_ = &own_.emplace(stepper, scene);
}

void StepWarnings::observe(const trajectory::Frame& frame) {
  passage_.observe(frame);
  if (own_)
    own_->observe(frame);
}

std::vector<Warning> StepWarnings::warnings() const {
  std::vector<Warning> found = passage_.warnings();
  const auto add = [&](std::vector<Warning> more) { std::ranges::move(more, std::back_inserter(found)); };
  if (load_)
    add(load_->warnings());
  if (errors_)
    add(errors_->warnings());
  return found;
}

} // namespace signorini::diagnostics
