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

/// Measured values of one quantity, in SI at ascending times.
struct Data {
  std::vector<double> times, values, deviations; ///< s; values; standard deviations
  std::vector<scene::TableWarning> warnings{};   ///< warnings about the table of these data
};

/// The quantities that a scene measures (docs/method.md section 10), along a motion and its derivatives by
/// the unknowns. Displacement and velocity are linear between the ends of steps. The force of step k acts in
/// its middle and is linear between; in contact-implicit steps, whose forces alternate, the mean of two steps
/// acts at the time between them. Contact times are none of these. All members collective.
class Measurements final : public step::StateDuals, public adjoint::VelocityForceDuals {
public:
  /// `times`: sample times of each of the scene's measurements, s. `columns`: 1 for the motion alone, one
  /// more for each derivative. The references must outlive this object. Throws UserError.
  Measurements(const step::Stepper& stepper, const step::TimeGrid& grid, const scene::Scene& scene,
               const std::vector<std::vector<double>>& times, std::size_t columns = 1);

  /// Takes the frame after the last one, from frame 0 on, and the derivatives there.
  void observe(const trajectory::Frame& frame);
  void observe(const trajectory::Frame& frame, const trajectory::ParameterSensitivities& sensitivities,
               const step::ParameterRates& rates);

  /// Number of values of all measurements together, and the first of each; those that are not fitted have
  /// none.
  [[nodiscard]] std::size_t count() const { return samples_.size(); }
  [[nodiscard]] const std::vector<std::size_t>& first() const { return first_; }

  /// Values of a column, once all frames have been taken: of the motion (0), or of its derivative by unknown
  /// j (j + 1).
  [[nodiscard]] std::vector<double> values(std::size_t column = 0) const;

  /// Sets the derivatives of J by the values, which determine the duals.
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
  /// A number of each state or step from which measurements are interpolated.
  struct Channel {
    scene::Quantity of; ///< displacement, velocity or force
    step::SparseFunctional field{};
    step::ObstacleComponent force{};
    std::vector<std::vector<double>> values{}; ///< values of each column (N + 1); a force's is zero at 0
  };
  /// A measured value: Σ weights · channel or, for an impulse, weights · sums of τ times a force so far.
  struct Sample {
    std::size_t channel;
    bool impulse;
    std::vector<std::pair<int, double>> weights;
  };

  [[nodiscard]] std::vector<std::pair<int, double>> at(double t, bool force) const;
  /// Force of a channel from the multipliers of rows.
  [[nodiscard]] double force(int k, const Channel& channel, std::span<const double> lambda,
                             const contact::ConstraintRows& rows) const;
  void take(int k, std::size_t column, Vec y, Vec v);

  const step::Stepper& stepper_;
  step::TimeGrid grid_;
  bool alternate_; ///< whether forces of single steps alternate
  int steps_;
  std::vector<Channel> channels_;
  std::vector<Sample> samples_;
  std::vector<std::size_t> first_;
  std::vector<std::vector<double>> derivative_; ///< ∂J/∂channel (channels × (N + 1))
};

} // namespace signorini::control
