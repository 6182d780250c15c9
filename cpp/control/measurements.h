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

/// What was measured of one quantity: values in SI at ascending times.
struct Data {
  std::vector<double> times, values, deviations; ///< s; deviations are standard
  std::vector<scene::TableWarning> warnings{};   ///< about the table that they come from
};

/// The quantities that a scene measures (docs/method.md section 10), along a motion and its derivatives by
/// the unknowns: displacement and velocity are linear between the ends of steps; the force of step k acts in
/// its middle, linear between; in contact-implicit steps, whose forces alternate, the mean of two steps acts
/// at the time between them. Contact times are none of these. All members collective.
class Measurements final : public step::StateDuals, public adjoint::VelocityForceDuals {
public:
  /// `times`: for each of the scene's measurements those at which it is wanted, s. `columns`: 1 for the
  /// motion alone, one more for each derivative. The references must outlive this object. Throws UserError.
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

  /// The values of a column, once all frames have been taken: of the motion (0), of its derivative by unknown
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
  /// A number of each state or step, of which measurements are interpolated.
  struct Channel {
    scene::Quantity of; ///< displacement, velocity or force
    step::SparseFunctional field{};
    step::ObstacleComponent force{};
    std::vector<std::vector<double>> values{}; ///< of each column (N + 1); a force's is zero at 0
  };
  /// A value: Σ weights · channel, or of the sums of a force so far, τ Σ.
  struct Sample {
    std::size_t channel;
    bool impulse;
    std::vector<std::pair<int, double>> weights;
  };

  [[nodiscard]] std::vector<std::pair<int, double>> at(double t, bool force) const;
  /// The force of a channel by multipliers of rows.
  [[nodiscard]] double force(int k, const Channel& channel, std::span<const double> lambda,
                             const contact::ConstraintRows& rows) const;
  void take(int k, std::size_t column, Vec y, Vec v);

  const step::Stepper& stepper_;
  step::TimeGrid grid_;
  bool alternate_; ///< forces of single steps do
  int steps_;
  std::vector<Channel> channels_;
  std::vector<Sample> samples_;
  std::vector<std::size_t> first_;
  std::vector<std::vector<double>> derivative_; ///< ∂J/∂channel (channels × (N + 1))
};

} // namespace signorini::control
