// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/parameter_rates.h"
#include "trajectory/time_integrator.h"

namespace signorini::trajectory {

/// Derivatives of a motion by the unknowns of a scene, on the motion's active sets (docs/method.md section
/// 9). Each step of the motion is followed by one linearised step for each unknown; a direct solver on one
/// rank reads its factor once for all of them. All members are collective.
class ParameterSensitivities {
public:
  /// Creates zero derivatives by the unknowns of `rates`. The references must outlive this object.
  ParameterSensitivities(const step::Stepper& stepper, step::ParameterRates& rates);

  /// Computes the derivatives at the next frame; frames are passed in order, from frame 0 on. Throws
  /// SolverFailure.
  void observe(const Frame& frame);

  /// Number of unknowns.
  [[nodiscard]] std::size_t count() const { return motions_.size(); }
  /// Returns δy_k, the derivative of the displacement by unknown j, at the last frame.
  [[nodiscard]] Vec y(std::size_t j) const { return motions_[j].state.y(); }
  /// Returns δv_k, the derivative of the velocity by unknown j, at the last frame.
  [[nodiscard]] Vec v(std::size_t j) const { return motions_[j].state.v(); }
  /// Returns δλ_k, one value per row of H: the derivative of the multipliers by unknown j, at the last frame.
  [[nodiscard]] std::span<const double> lambda(std::size_t j) const { return motions_[j].lambda; }

private:
  struct Derivative {
    step::State state;
    std::vector<double> lambda;
  };
  /// Scratch of a linearised step.
  struct Scratch {
    explicit Scratch(const step::Stepper& stepper);
    step::Stepper::Workspace work;
    step::State from;
    petsc::Vector source, force;
    std::vector<double> normal, law, predictor_normal, zeta;
  };
  /// Makes the linearised step for unknown j.
  void step(const Frame& frame, std::size_t j, Scratch& scratch);

  const step::Stepper& stepper_;
  step::ParameterRates& rates_;
  std::vector<Derivative> motions_;
  std::vector<Scratch> scratch_; ///< one for each unknown if steps are made together, else one
  Lockstep lockstep_;
};

} // namespace signorini::trajectory
