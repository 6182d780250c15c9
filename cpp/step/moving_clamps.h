// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/operators.h"
#include "scene/expression.h"
#include "step/time_grid.h"

namespace signorini::step {

/// Moving clamps of a scene, which prescribe y_k = γ(t_k) and v_k = γ′(t_k) on their dofs and thereby load
/// the free dofs (docs/method.md section 2). The velocity recursion of the free dofs is not used on the
/// moving ones. It would keep an error of v, or a jump of γ′, with alternating sign in all later steps, and
/// excite the body through the mass that couples clamped and free dofs.
class MovingClamps {
public:
  /// Selects the moving clamps of `clamps` and finds their nodes. `space` must outlive this object. Throws
  /// UserError.
  MovingClamps(const fem::Space& space, const std::vector<scene::Clamp>& clamps);

  /// Returns whether any of `clamps` prescribes a displacement other than zero.
  [[nodiscard]] static bool in(const std::vector<scene::Clamp>& clamps);

  /// Values of γ(t_k), m, and γ′(t_k), m/s, on the moving dofs (zero on all others), and scratch vectors.
  struct Evaluation {
    double t = -1; ///< t_k of the last evaluation, s; negative: nothing is evaluated yet
    /// Interval from t_k in which γ is differentiated, s: −τ_k; for k = 0 the first τ.
    double difference_interval = 0;
    PetscObjectId forced = 0; ///< PETSc's id of the matrix D in `force` = D γ; 0: `force` is not evaluated
    petsc::Vector position, velocity, force, starting_velocity;
  };
  /// Allocates the vectors for evaluate(). Collective.
  [[nodiscard]] Evaluation storage() const;
  /// Evaluates γ and γ′ at the end of `step` (for k = 0 at t_0) into `at`. Collective. Throws UserError if a
  /// value is not finite.
  void evaluate(const TimeStep& step, Evaluation& at) const;

  /// Adds the clamps' motion in a step, evaluated in `at`, to the right-hand side `r` of the step. Adds the
  /// force −D γ on free dofs, where `D` is the matrix before its clamped dofs were decoupled. Sets `r` to
  /// `diagonal` γ on `clamped` dofs, where `diagonal` is the diagonal entry of the decoupled matrix.
  /// Collective.
  void apply(Evaluation& at, Mat D, const fem::DirichletDofs& clamped, double diagonal, Vec r) const;

  /// Returns the velocity to be used in place of `v` = v_{k−1} in the right-hand side of step k. It differs
  /// from `v` on the moving dofs, so that the mass transfers the clamps' acceleration (v_k − v_{k−1})/τ to
  /// the free dofs. `y`: displacement before the step; `at`: evaluated at the end of the step. The result is
  /// stored in at.starting_velocity. Collective.
  [[nodiscard]] Vec starting_velocity(Evaluation& at, Vec y, Vec v) const;

  /// Copies the entries of the moving dofs from `from` to `to`.
  void copy(Vec from, Vec to) const;

private:
  struct Clamp {
    scene::Field field;
    std::vector<int> nodes, components;
  };
  /// Calls visit(dof) for all moving dofs, with local numbers.
  template <class Visit>
  void for_each_dof(Visit&& visit) const;

  const fem::Space& space_;
  std::vector<Clamp> clamps_;
  bool at_rest_; ///< whether γ is constant in time
};

} // namespace signorini::step
