// SPDX-License-Identifier: GPL-3.0-or-later
#include "forward/step_warnings.h"
#include <algorithm>
#include <iterator>

namespace signorini::forward {

StepWarnings::StepWarnings(const Stepper& stepper, const scene::Scene& scene, const SceneLoad* load,
                           const StepErrors* errors)
    : load_(load), passage_(stepper), errors_(errors) {
  if (!errors && stepper.ladder())
    errors_ = &own_.emplace(stepper, scene);
}

void StepWarnings::observe(const Frame& frame) {
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

} // namespace signorini::forward
