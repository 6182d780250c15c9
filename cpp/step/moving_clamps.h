// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/operators.h"
#include "scene/expression.h"
#include "step/time_grid.h"

namespace signorini::step {

/// Clamps that move as the scene prescribes (docs/method.md section 2): y_k = γ(t_k) and v_k = γ′(t_k) on
/// their dofs, which act on the free ones as loads. The recursion for the free dofs' velocities is not used
/// on them: it would keep an error of v, or a jump of γ′, for ever with alternating sign, and excite the body
/// through the mass that couples clamped and free dofs.
class MovingClamps {
public:
  /// Throws UserError.
  MovingClamps(const fem::Space& space, const std::vector<scene::Clamp>& clamps);

  /// Whether any of the clamps moves.
  [[nodiscard]] static bool in(const std::vector<scene::Clamp>& clamps);

  /// γ(t_k) and γ′(t_k) on the moving dofs, zero elsewhere, and scratch.
  struct At {
    double t = -1, reach = 0; ///< time and signed step of the evaluation, s; t < 0: none
    PetscObjectId forced = 0; ///< id of the D in `force` = D γ; 0: not evaluated
    petsc::Vector position, velocity, force, driving;
  };
  [[nodiscard]] At storage() const;
  /// Evaluates γ and γ′ at the end of a step, or at t_0. Collective. Throws UserError if they are not finite.
  void evaluate(const TimeStep& step, At& at) const;

  /// Adds the motion of a step to the right-hand side `r` of the system with decoupled D: the force −D γ on
  /// the free dofs, with the `D` before its clamped dofs were decoupled. Sets the `clamped` entries to γ
  /// times `diagonal`, the entry of the decoupled D there. Collective.
  void apply(At& at, Mat D, const fem::DirichletDofs& clamped, double diagonal, Vec r) const;

  /// Returns, in at.driving, `v` with its moving dofs changed: for the state `y`, `v` before the step, the
  /// mass then transfers the clamps' acceleration (v_k − v_{k−1})/τ to the free dofs. Collective.
  [[nodiscard]] Vec driving(At& at, Vec y, Vec v) const;

  /// Copies the entries of the moving dofs.
  void copy(Vec from, Vec to) const;

private:
  struct Clamp {
    scene::Field field;
    std::vector<int> nodes, components;
  };
  /// Calls visit(dof) for all moving dofs.
  template <class Visit>
  void for_each_dof(Visit&& visit) const;

  const fem::Space& space_;
  std::vector<Clamp> clamps_;
  bool at_rest_; ///< whether γ is constant in time
};

} // namespace signorini::step
