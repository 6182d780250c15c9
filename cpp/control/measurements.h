// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "adjoint/sweep.h"
#include "scene/table.h"
#include "step/functionals.h"
#include "trajectory/parameter_sensitivities.h"
#include <array>
#include <span>
#include <string>
#include <vector>

namespace signorini::control {

/// Measured values of one quantity, in SI units, at ascending times.
struct Data {
  std::vector<double> times, values, deviations; ///< times, s; values; their standard deviations
  std::vector<scene::TableWarning> warnings{};   ///< warnings about the table of these data
};

/// Simulated values of the quantities that a scene measures, along a motion, and the derivatives of these
/// values by the unknowns (docs/method.md section 10). Displacement and velocity are linear between the ends
/// of steps. The force of step k acts in the step's middle and is linear between middles. In contact-implicit
/// steps and with friction, where forces alternate, the mean of two steps acts at the time between them.
/// Contact times are not included. All members are collective.
class Measurements final : public step::StateDuals, public adjoint::VelocityForceDuals {
public:
  /// `times`: sample times of each of the scene's measurements, s. `columns`: number of columns of values: 1
  /// for the motion alone, 1 more for each derivative. The references must outlive this object. Throws
  /// UserError.
  Measurements(const step::Stepper& stepper, const step::TimeGrid& grid, const scene::Scene& scene,
               const std::vector<std::vector<double>>& times, std::size_t columns = 1);

  /// Records the values of the next frame; frames are passed in order, from frame 0 on.
  void observe(const trajectory::Frame& frame);
  /// Records the values of the next frame and their derivatives by the unknowns; frames are passed in order,
  /// from frame 0 on.
  void observe(const trajectory::Frame& frame, const trajectory::ParameterSensitivities& sensitivities,
               const step::ParameterRates& rates);

  /// Number of values of all fitted measurements together.
  [[nodiscard]] std::size_t count() const { return samples_.size(); }
  /// Returns the index of each measurement's first value, followed by count(). Measurements that are not
  /// fitted have no values.
  [[nodiscard]] const std::vector<std::size_t>& first() const { return first_; }

  /// Returns a column of simulated values; call it after the last frame. Column 0 contains the values along
  /// the motion, column j + 1 their derivatives by unknown j.
  [[nodiscard]] std::vector<double> values(std::size_t column = 0) const;

  /// Sets the derivatives of J by the simulated values, from which add() and forces() compute duals of states
  /// and forces.
  void set_derivative(std::span<const double> by_values);

  [[nodiscard]] bool has_density() const override { return false; }
  [[nodiscard]] bool has_vector() const override { return true; }
  void add(const step::TimeStep& step, step::StateDual sum) const override;
  [[nodiscard]] std::size_t velocities() const override;
  void velocity_factors(int k, std::span<double> factors) const override;
  void add_velocities(std::span<const double> factors, Vec sum) const override;
  [[nodiscard]] bool of_forces() const override;
  void forces(int k, std::span<double> dual) const override;
  [[nodiscard]] double by_rows(int k, const contact::ContactLinearisation& contact,
                               const contact::ConstraintRows& rate) const override;

private:
  /// A quantity of each state or step, from which measurements are interpolated.
  struct Channel {
    scene::Quantity of; ///< displacement, velocity or force
    step::SparseFunctional field{};
    step::ObstacleComponent force{};
    std::vector<std::vector<double>> values{}; ///< values in each column (N + 1); a force is zero at entry 0
  };
  /// Simulated counterpart of a measured value: Σ weights · channel. For an impulse the weights apply to the
  /// sums of τ times the force up to each step.
  struct Sample {
    std::size_t channel;
    bool impulse;
    std::vector<std::pair<int, double>> weights;
  };

  /// Returns the steps and weights that interpolate a state or, if `force`, a force at time `t` (s).
  [[nodiscard]] std::vector<std::pair<int, double>> at(double t, bool force) const;
  /// Returns the force of a channel in step k from the multipliers `lambda` of the rows.
  [[nodiscard]] double force(int k, const Channel& channel, std::span<const double> lambda,
                             const contact::ConstraintRows& rows) const;
  /// Records the displacement and velocity channels of a column at t_k.
  void take(int k, std::size_t column, Vec y, Vec v);

  const step::Stepper& stepper_;
  step::TimeGrid grid_;
  bool alternate_; ///< whether forces of single steps alternate, as friction where candidates stick does
  int steps_;
  std::vector<Channel> channels_;
  std::vector<Sample> samples_;
  std::vector<std::size_t> first_;
  std::vector<std::vector<double>> derivative_; ///< ∂J/∂channel (channels × (N + 1))
};

} // namespace signorini::control
