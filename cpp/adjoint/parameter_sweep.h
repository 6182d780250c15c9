// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "forward/parameter_rates.h"
#include "forward/trajectory.h"
#include <functional>
#include <vector>

namespace signorini::adjoint {

/// Derivatives of a function J of a motion by its states and contact forces, the unknowns held fixed. All
/// members collective.
class MotionDuals {
public:
  virtual ~MotionDuals() = default;
  /// sum += ∂J/∂y_k, a functional, k = 0…N.
  virtual void add_displacement(int k, Vec sum) const = 0;
  /// ∂J/∂v_k as factors of a few functionals, the same for all k, into `factors`; and sum += Σ factors ·
  /// these.
  [[nodiscard]] virtual std::size_t velocities() const = 0;
  virtual void velocity_factors(int k, std::span<double> factors) const = 0;
  virtual void add_velocities(std::span<const double> factors, Vec sum) const = 0;
  /// Whether any ∂J/∂λ_k is not zero.
  [[nodiscard]] virtual bool of_forces() const = 0;
  /// Sets ∂J/∂λ_k (m), k = 1…N.
  virtual void forces(int k, std::span<double> dual) const = 0;
  /// What J changes by if the rows of constraints change by `rate`, for the multipliers of step k.
  [[nodiscard]] virtual double by_rows(int k, const contact::ContactLinearisation& contact,
                                       const contact::ConstraintRows& rate) const = 0;
};

/// dJ/dθ by one backward sweep for all unknowns θ (docs/method.md section 9), along a motion that has whole
/// states; `visit(k, p_k)`, if given, receives the adjoint states, each valid during the call. Collective.
/// Throws SolverFailure naming the step.
std::vector<double> parameter_gradient(const forward::Stepper& stepper, forward::Stepper::Workspace& work,
                                       const forward::Trajectory& motion, const MotionDuals& duals,
                                       forward::ParameterRates& rates,
                                       const std::function<void(int k, Vec p)>& visit = {});

} // namespace signorini::adjoint
