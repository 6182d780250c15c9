// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control.h"
#include <span>
#include <vector>

namespace signorini {

struct CompactJointVector;

/// A control and a scene's unknowns, on their scales, sought together. The unknowns are the same on every
/// rank.
struct JointVector {
  control::Control u;
  std::vector<double> x;

  JointVector(control::Control control, std::vector<double> unknowns)
      : u(std::move(control)), x(std::move(unknowns)) {}
  explicit JointVector(const CompactJointVector& compact);

  void add(double a, const JointVector& v) {
    u.add(a, v.u);
    axpy(a, v.x, x);
  }
  /// this += Σ a_i v_i.
  void add(std::span<const double> a, std::span<const CompactJointVector> v);
  void scale(double a) {
    u.scale(a);
    signorini::scale(a, x);
  }
};

/// The same with the control in single precision.
struct CompactJointVector {
  control::CompactControl u{};
  std::vector<double> x{};

  CompactJointVector() = default;
  explicit CompactJointVector(const JointVector& v) : u(v.u), x(v.x) {}

  /// As CompactControl::combine().
  static void combine(std::vector<CompactJointVector>& v, const std::vector<std::vector<double>>& factors);
};

/// Those of the controls of a list, which are shared.
[[nodiscard]] std::vector<control::CompactControl> controls_of(std::span<const CompactJointVector> v);

} // namespace signorini
