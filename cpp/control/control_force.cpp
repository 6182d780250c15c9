// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/control_force.h"

namespace signorini::control {

SampledForce::SampledForce(const ControlSpace& controls, const scene::Components& components,
                           const std::string& key, bool within)
    : controls_(controls), field_(components, key, !controls.constant_in_time()), within_(within),
      values_(controls.size(), 1) {}

void SampledForce::add(int k, forward::NodalForce sum) const {
  const double t = controls_.middle(controls_.interval(k));
  if (at_ < 0 || (field_.depends_on_time() && at_ != t)) {
    fem::interpolate(controls_.space().comm(), field_, t, controls_.points(), controls_.components(),
                     values_.at(1));
    if (within_)
      controls_.project(values_);
  }
  at_ = t;
  controls_.add_force(values_.at(1), sum);
}

} // namespace signorini::control
