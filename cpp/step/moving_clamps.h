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
    double t = -1, reach = 0; ///< what it was evaluated for, s; t < 0: not
    PetscObjectId forced = 0; ///< the D of which `force` is D γ; 0: not evaluated
    petsc::Vector position, velocity, force, driving;
  };
  [[nodiscard]] At storage() const;
  /// Evaluates them at the end of a step, or at t_0. Collective. Throws UserError where they are not finite.
  void evaluate(const TimeStep& step, At& at) const;

  /// Puts the motion of a step into the right-hand side `r` of the system with decoupled D: adds the force −D
  /// γ on the free dofs, where `D` is the one before its clamped dofs were decoupled, and sets the `clamped`
  /// ones to D's entry `diagonal` there times γ. Collective.
  void apply(At& at, Mat D, const fem::DirichletDofs& clamped, double diagonal, Vec r) const;

  /// `v` with its moving dofs changed such that, for the state `y`, `v` before the step, the mass transfers
  /// the clamps' acceleration (v_k − v_{k−1})/τ to the free dofs; in at.driving. Collective.
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
  bool at_rest_; ///< γ does not depend on time
};

} // namespace signorini::step
