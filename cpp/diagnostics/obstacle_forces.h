// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "trajectory/integrate.h"
#include <array>
#include <vector>

namespace signorini::diagnostics {

/// What contact does to the body in a step, and has done so far; in 2D forces are N/m, impulses N s/m.
struct ObstacleForce {
  std::array<double, 3> force{};   ///< resultant on the body, N
  double normal_force = 0;         ///< sum of the moduli of the nodal forces, N
  int active = 0;                  ///< candidates in contact
  double min_gap = 0;              ///< the least gap of a candidate, m
  std::array<double, 3> impulse{}; ///< Σ τ_k F_k of the steps so far, N s
};

/// The contact forces of a motion by obstacles, frame by frame. The force of step k, docs/method.md section
/// 2, acts from t_{k−1} to t_k. Not collective: candidates are known to every rank.
class ObstacleForces {
public:
  /// Without contact there are no obstacles. `stepper` must outlive this object.
  explicit ObstacleForces(const step::Stepper& stepper);

  /// Takes the frame after the last one, from frame 0 on, in which no force acts yet. Allocates at the first.
  void observe(const trajectory::Frame& frame);

  /// By the number of the obstacle in the scene.
  [[nodiscard]] const std::vector<ObstacleForce>& each() const { return each_; }
  /// Of all obstacles together.
  [[nodiscard]] const ObstacleForce& all() const { return all_; }

private:
  const step::Stepper& stepper_;
  std::vector<ObstacleForce> each_;
  ObstacleForce all_;
  std::vector<double> forces_; ///< of rows, N
};

/// Finds the step of the largest contact force of a motion: of those whose forces differ by rounding alone
/// the first, which is the same on any number of ranks.
class LargestForce {
public:
  /// Takes the normal force of the next step, N; whether it is the largest so far.
  bool observe(double force);

private:
  double largest_ = 0;
};

} // namespace signorini::diagnostics
