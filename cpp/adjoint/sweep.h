// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/parameter_rates.h"
#include "trajectory/trajectory.h"
#include <functional>
#include <vector>

namespace signorini::adjoint {

/// Derivatives of a function J of a motion by its velocities and contact forces. All members collective.
class VelocityForceDuals {
public:
  virtual ~VelocityForceDuals() = default;
  /// Number of functionals that form ∂J/∂v_k, the same for all k. velocity_factors() sets their factors,
  /// add_velocities() adds Σ factors · functionals to `sum`.
  [[nodiscard]] virtual std::size_t velocities() const = 0;
  virtual void velocity_factors(int k, std::span<double> factors) const = 0;
  virtual void add_velocities(std::span<const double> factors, Vec sum) const = 0;
  /// Whether any ∂J/∂λ_k is not zero.
  [[nodiscard]] virtual bool of_forces() const = 0;
  /// Sets ∂J/∂λ_k (m), k = 1…N.
  virtual void forces(int k, std::span<double> dual) const = 0;
  /// Change of J as the rows of constraints change by `rate`, for the multipliers of step k.
  [[nodiscard]] virtual double by_rows(int k, const contact::ContactLinearisation& contact,
                                       const contact::ConstraintRows& rate) const = 0;
};

/// Receives the adjoint states p_N … p_1, each valid during the call.
using AdjointObserver = std::function<void(int k, Vec p)>;

/// The backward sweep p_N … p_1 (4.40)–(4.41), docs/method.md section 4, of a J that depends on displacements
/// alone. Makes for each step of a motion the adjoint step on its whole active set A_k, given by `contact`
/// (0…N); `grid` has these N steps. `by_displacements` is ∂J/∂y_k. Collective. Throws SolverFailure naming
/// the step.
void sweep(const step::Stepper& stepper, step::Stepper::Workspace& work, const step::TimeGrid& grid,
           const std::vector<contact::ContactLinearisation>& contact,
           const step::DualAtStep& by_displacements, const AdjointObserver& visit);

/// The backward sweep along a motion that has whole states, of a J of velocities and forces too. Returns
/// dJ/dθ for all unknowns θ at once (docs/method.md section 9). Both derivatives are taken at fixed unknowns;
/// `by_displacements` must have a vector part where J depends on velocities.
std::vector<double> sweep(const step::Stepper& stepper, step::Stepper::Workspace& work,
                          const trajectory::Trajectory& motion, const step::DualAtStep& by_displacements,
                          const VelocityForceDuals& duals, step::ParameterRates& rates,
                          const AdjointObserver& visit = {});

} // namespace signorini::adjoint
