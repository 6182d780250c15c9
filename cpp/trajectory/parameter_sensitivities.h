// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/parameter_rates.h"
#include "trajectory/time_integrator.h"

namespace signorini::trajectory {

/// The derivatives of a motion by the unknowns of a scene, on its active sets (docs/method.md section 9): one
/// linearised step for each unknown with every step that is made. All members collective.
class ParameterSensitivities {
public:
  /// The references must outlive this object.
  ParameterSensitivities(const step::Stepper& stepper, step::ParameterRates& rates);

  /// Takes the frame after the last one, from frame 0 on. Throws SolverFailure.
  void observe(const Frame& frame);

  [[nodiscard]] std::size_t count() const { return motions_.size(); }
  /// δy_k, δv_k, δλ_k (m), of the frame taken last, per unit of the unknown j.
  [[nodiscard]] Vec y(std::size_t j) const { return motions_[j].state.y(); }
  [[nodiscard]] Vec v(std::size_t j) const { return motions_[j].state.v(); }
  [[nodiscard]] std::span<const double> lambda(std::size_t j) const { return motions_[j].lambda; }

private:
  struct Derivative {
    step::State state;
    std::vector<double> lambda;
  };

  const step::Stepper& stepper_;
  step::ParameterRates& rates_;
  step::Stepper::Workspace work_;
  step::State from_;
  petsc::Vector source_, force_;
  std::vector<double> normal_, predictor_normal_, zeta_;
  std::vector<Derivative> motions_;
};

} // namespace signorini::trajectory
