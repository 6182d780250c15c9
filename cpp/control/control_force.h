// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control_space.h"
#include "fem/time_profile.h"
#include <string>
#include <utility>

namespace signorini::control {

/// The force of a control that expressions give, its mean over each interval, evaluated as steps ask for it:
/// not more than one interval is stored.
class SampledForce final : public step::Load {
public:
  /// `key` names it in messages; `within`: it is clipped to the bounds. `controls` must outlive this object.
  /// Throws UserError.
  SampledForce(const ControlSpace& controls, const scene::Components& components, const std::string& key,
               bool within);
  [[nodiscard]] bool has_density() const override { return controls_.acts_by_density(); }
  [[nodiscard]] bool has_vector() const override { return !controls_.acts_by_density(); }
  void add(const step::TimeStep& step, step::NodalForce sum) const override;
  [[nodiscard]] double variation(double from, double to) const override {
    return profile_.variation(from, to);
  }

private:
  const ControlSpace& controls_;
  fem::TimeProfile profile_;
  bool within_;
  // Several steps may lie in an interval, and its expressions take longer than a step's products.
  mutable Control values_;                     ///< of the interval evaluated last
  mutable std::pair<double, double> of_{0, 0}; ///< from its begin to its end, s
};

/// The force s u_k of a control on the body, as a load.
class ControlForce final : public step::Load {
public:
  /// The references must outlive this object.
  ControlForce(const ControlSpace& controls, const Control& u) : controls_(controls), u_(u) {}
  [[nodiscard]] bool has_density() const override { return controls_.acts_by_density(); }
  [[nodiscard]] bool has_vector() const override { return !controls_.acts_by_density(); }
  void add(const step::TimeStep& step, step::NodalForce sum) const override {
    controls_.for_each_interval(step, [&](int j, double part) { controls_.add_force(u_.at(j), sum, part); });
  }
  [[nodiscard]] double variation(double from, double to) const override {
    return controls_.variation(u_, from, to);
  }

private:
  const ControlSpace& controls_;
  const Control& u_;
};

/// The same in a motion of other steps than those of the control.
class HeldForce final : public step::Load {
public:
  /// The references must outlive this object.
  HeldForce(const ControlSpace& controls, const Control& u) : controls_(controls), u_(u) {}
  [[nodiscard]] bool has_density() const override { return controls_.acts_by_density(); }
  [[nodiscard]] bool has_vector() const override { return !controls_.acts_by_density(); }
  void add(const step::TimeStep& step, step::NodalForce sum) const override {
    controls_.for_each_interval(step.begin, step.end,
                                [&](int j, double part) { controls_.add_force(u_.at(j), sum, part); });
  }
  [[nodiscard]] double variation(double from, double to) const override {
    return controls_.variation(u_, from, to);
  }

private:
  const ControlSpace& controls_;
  const Control& u_;
};

} // namespace signorini::control
