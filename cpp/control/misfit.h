// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/measurements.h"
#include "optimize/gauss_newton.h"
#include "scene/parameters.h"
#include <span>
#include <vector>

namespace signorini::control {

/// Least-squares misfit ½|r|² of a scene's parameters θ (docs/method.md sections 9 and 10). A search varies
/// x, where each x is θ or log θ. The residuals r are those of the data, in standard deviations, followed by
/// those of the priors.
class Misfit {
public:
  /// `data`: data of all measurements of the scene. `scene` must outlive this object.
  Misfit(const scene::Scene& scene, std::vector<Data> data);

  /// Returns the scene's start values of the parameters as x (θ or log θ).
  [[nodiscard]] std::vector<double> start() const { return on_scales(scene::start_values(scene_)); }
  /// Returns the bounds of x (θ or log θ) and the limits of its steps.
  [[nodiscard]] const optimize::Box& box() const { return box_; }
  /// Converts x (θ or log θ) to parameters θ.
  [[nodiscard]] std::vector<double> values(std::span<const double> x) const;
  /// Converts parameters θ to x (θ or log θ).
  [[nodiscard]] std::vector<double> on_scales(std::span<const double> values) const;
  /// Returns the derivatives dθ/dx at x.
  [[nodiscard]] std::vector<double> slopes(std::span<const double> x) const;

  [[nodiscard]] const scene::Scene& scene() const { return scene_; }
  [[nodiscard]] const std::vector<Data>& data() const { return data_; }
  /// Returns warnings about the tables of the data.
  [[nodiscard]] std::vector<scene::TableWarning> warnings() const;
  /// Number of measured values of all measurements.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Returns the times at which each measurement has values, s.
  [[nodiscard]] std::vector<std::vector<double>> times() const;

  /// Returns the residuals r at x, given the simulated values of the measurements.
  [[nodiscard]] std::vector<double> residuals(const std::vector<double>& simulated,
                                              std::span<const double> x) const;
  /// Returns the Jacobian ∂r/∂x (residuals × parameters, column by column), given the derivatives of the
  /// simulated values by θ.
  [[nodiscard]] std::vector<double> jacobian(const std::vector<std::vector<double>>& by_theta,
                                             std::span<const double> x) const;
  /// Returns the derivatives of ½|r|² by the simulated values of the measurements.
  [[nodiscard]] std::vector<double> by_values(const std::vector<double>& residuals) const;
  /// Returns the gradient d(½|r|²)/dx, the priors' part included, given the derivatives of the data's part by
  /// θ.
  [[nodiscard]] std::vector<double> gradient(std::vector<double> by_theta,
                                             const std::vector<double>& residuals,
                                             std::span<const double> x) const;

private:
  const scene::Scene& scene_;
  std::vector<Data> data_;
  std::size_t count_ = 0;
  optimize::Box box_;
};

} // namespace signorini::control
