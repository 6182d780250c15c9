// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/parameter_rates.h"
#include "trajectory/trajectory.h"
#include <functional>
#include <vector>

namespace signorini::adjoint {

/// Derivatives of a function J of a motion by the velocities v_k and the contact multipliers λ_k. All members
/// are collective.
class VelocityForceDuals {
public:
  virtual ~VelocityForceDuals() = default;
  /// Returns the number of functionals φ_i of which ∂J/∂v_k = Σ_i factor_i φ_i consists; they are the same
  /// for all k.
  [[nodiscard]] virtual std::size_t velocities() const = 0;
  /// Sets the factors of the functionals φ_i in ∂J/∂v_k.
  virtual void velocity_factors(int k, std::span<double> factors) const = 0;
  /// Adds Σ_i factors_i φ_i to `sum`, φ_i being the functionals of which ∂J/∂v_k consists.
  virtual void add_velocities(std::span<const double> factors, Vec sum) const = 0;
  /// Returns whether any derivative ∂J/∂λ_k differs from zero.
  [[nodiscard]] virtual bool of_forces() const = 0;
  /// Sets `dual`, which has one entry for each multiplier, to ∂J/∂λ_k, k = 1…N.
  virtual void forces(int k, std::span<double> dual) const = 0;
  /// Returns the derivative of J in the direction `rate` of the constraint rows at step k, whose multipliers
  /// in `contact` are fixed.
  [[nodiscard]] virtual double by_rows(int k, const contact::ContactLinearisation& contact,
                                       const contact::ConstraintRows& rate) const = 0;
};

/// Function that receives the adjoint states p_N … p_1 in this order; `p` is valid only during the call.
using AdjointObserver = std::function<void(int k, Vec p)>;

/// Computes the adjoint states p_N … p_1 by a backward sweep (4.40)–(4.41) (docs/method.md section 4), for a
/// J that depends on displacements alone, and passes them to `visit`. Each transposed step is taken on the
/// whole active set A_k in `contact` (0…N); `grid` has these N steps. `by_displacements`: ∂J/∂y_k.
/// Collective. Throws SolverFailure naming the step.
void sweep(const step::Stepper& stepper, step::Stepper::Workspace& work, const step::TimeGrid& grid,
           const std::vector<contact::ContactLinearisation>& contact,
           const step::DualAtStep& by_displacements, const AdjointObserver& visit);

/// Computes dJ/dθ for all unknowns θ of a scene by one backward sweep (docs/method.md section 9), for a J
/// that also depends on velocities and forces. `motion` must store displacements and velocities.
/// `by_displacements` and `duals`: derivatives of J at fixed unknowns. If J depends on velocities,
/// `by_displacements` must have a vector part, since the terms of the velocities are added to it. Passes
/// p_N … p_1 to `visit`, if given. Collective. Throws SolverFailure naming the step.
std::vector<double> sweep(const step::Stepper& stepper, step::Stepper::Workspace& work,
                          const trajectory::Trajectory& motion, const step::DualAtStep& by_displacements,
                          const VelocityForceDuals& duals, step::ParameterRates& rates,
                          const AdjointObserver& visit = {});

} // namespace signorini::adjoint
