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
  struct At {
    double t = -1, reach = 0; ///< t_k and signed step of the last evaluation, s; t < 0: none
    PetscObjectId forced = 0; ///< PETSc's id of the matrix D in `force` = D γ; 0: `force` is not evaluated
    petsc::Vector position, velocity, force, starting_velocity;
  };
  /// Allocates the vectors for evaluate(). Collective.
  [[nodiscard]] At storage() const;
  /// Evaluates γ and γ′ at the end of `step` (for k = 0 at t_0) into `at`. Collective. Throws UserError if a
  /// value is not finite.
  void evaluate(const TimeStep& step, At& at) const;

  /// Adds the clamps' motion in a step, evaluated in `at`, to `r`, the right-hand side of the system whose D
  /// has its clamped dofs decoupled. On free dofs this is the force −D γ, with `D` before decoupling. Entries
  /// on `clamped` dofs become `diagonal` γ, `diagonal` being the decoupled D's entry there. Collective.
  void apply(At& at, Mat D, const fem::DirichletDofs& clamped, double diagonal, Vec r) const;

  /// Returns the velocity `v` before a step with other values on the moving dofs. With these in the step's
  /// right-hand side, the mass transfers the clamps' acceleration (v_k − v_{k−1})/τ to the free dofs. `y`:
  /// displacement before the step; `at`: evaluated at its end. The result is stored in at.starting_velocity.
  /// Collective.
  [[nodiscard]] Vec starting_velocity(At& at, Vec y, Vec v) const;

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
