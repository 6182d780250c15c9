// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/measurements.h"
#include "optimize/gauss_newton.h"
#include "scene/parameters.h"
#include <span>
#include <vector>

namespace signorini::control {

/// The least-squares misfit ½|r|² of a scene's parameters θ (docs/method.md sections 9 and 10). A search
/// varies them on their scales, x = θ or log θ. The residuals r are those of the data, in standard
/// deviations, and those of the priors.
class Misfit {
public:
  /// `data`: of all measurements of the scene, which must outlive this object.
  Misfit(const scene::Scene& scene, std::vector<Data> data);

  /// The scene's own parameters, on their scales, and their bounds.
  [[nodiscard]] std::vector<double> start() const { return on_scales(scene::start_values(scene_)); }
  [[nodiscard]] const optimize::Box& box() const { return box_; }
  /// Converts x to θ, and θ to x.
  [[nodiscard]] std::vector<double> values(std::span<const double> x) const;
  [[nodiscard]] std::vector<double> on_scales(std::span<const double> values) const;
  /// Derivatives dθ/dx at x.
  [[nodiscard]] std::vector<double> slopes(std::span<const double> x) const;

  [[nodiscard]] const scene::Scene& scene() const { return scene_; }
  [[nodiscard]] const std::vector<Data>& data() const { return data_; }
  /// Warnings about the tables of the data.
  [[nodiscard]] std::vector<scene::TableWarning> warnings() const;
  /// Number of values of all measurements.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Times at which each measurement has values, s.
  [[nodiscard]] std::vector<std::vector<double>> times() const;

  /// Residuals r from the simulated values of the measurements.
  [[nodiscard]] std::vector<double> residuals(const std::vector<double>& simulated,
                                              std::span<const double> x) const;
  /// Jacobian ∂r/∂x (residuals × parameters, column by column) from the derivatives of the simulated values
  /// by θ.
  [[nodiscard]] std::vector<double> jacobian(const std::vector<std::vector<double>>& by_theta,
                                             std::span<const double> x) const;
  /// Derivatives of ½|r|² by the values of the measurements.
  [[nodiscard]] std::vector<double> by_values(const std::vector<double>& residuals) const;
  /// Gradient d(½|r|²)/dx, the priors' part included, from the data's d/dθ.
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
