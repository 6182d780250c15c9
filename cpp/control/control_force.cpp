// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/control_force.h"

namespace signorini::control {

SampledForce::SampledForce(const ControlSpace& controls, const scene::Components& components,
                           const std::string& key, bool within)
    : controls_(controls),
      profile_(controls.space().comm(), scene::Field(components, key, !controls.constant_in_time()),
               controls.points(), controls.grid().end()),
      within_(within), values_(controls.size(), 1) {
  profile_.require_resolved();
}

void SampledForce::add(const step::TimeStep& step, step::NodalForce sum) const {
  controls_.for_each_interval(step, [&](int j, double part) {
    const bool own = !controls_.stepwise(); // steps may still be unknown to `controls_`
    const double begin = own ? controls_.begin(j) : step.begin;
    const std::pair of(begin, begin + (own ? controls_.length(j) : step.tau));
    const bool first = of_.second == 0;
    if (first || (profile_.field().depends_on_time() && of_ != of)) {
      profile_.mean(of.first, of.second, controls_.components(), values_.at(1));
      if (within_)
        controls_.project(values_);
      of_ = of;
    }
    controls_.add_force(values_.at(1), sum, part);
  });
}

} // namespace signorini::control
