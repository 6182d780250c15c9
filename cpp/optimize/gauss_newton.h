// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/report.h"
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <vector>

/// Nonlinear least squares of few unknowns: Gauss-Newton steps, damped after Levenberg and Marquardt, within
/// bounds. min ½ |r(x)|² over lower ≤ x ≤ upper.
namespace signorini::optimize {

/// Residuals r (m) and their derivatives (m × n, column by column) at a point.
struct LeastSquares {
  std::vector<double> residuals, jacobian;

  [[nodiscard]] double value() const;
  /// Number of unknowns n.
  [[nodiscard]] std::size_t columns() const {
    return residuals.empty() ? 0 : jacobian.size() / residuals.size();
  }
  /// Jᵀr (n) and JᵀJ (n × n).
  [[nodiscard]] std::vector<double> gradient() const;
  [[nodiscard]] std::vector<double> normal_matrix() const;
};

/// Bounds of the unknowns, ±∞ where there are none.
struct Box {
  std::vector<double> lower, upper;
  /// Largest change of each unknown in one step, beyond which the linearised residuals are meaningless; no
  /// limit if empty.
  std::vector<double> longest = {};

  /// Whether x_i is at a bound beyond which −g_i points.
  [[nodiscard]] bool blocks(std::size_t i, double x, double g) const {
    return (x <= lower[i] && g > 0) || (x >= upper[i] && g < 0);
  }
  /// Whether one step may take an unknown from x to `next`.
  [[nodiscard]] bool reaches(std::size_t i, double x, double next) const {
    return longest.empty() || std::abs(next - x) <= longest[i];
  }
  /// Value nearest to `wanted` that one step from x may reach.
  [[nodiscard]] double nearest(std::size_t i, double x, double wanted) const {
    if (!reaches(i, x, wanted))
      wanted = x + std::copysign(longest[i], wanted - x);
    return std::clamp(wanted, lower[i], upper[i]);
  }
};

struct GaussNewtonOptions {
  int max_iterations = 100;
  double tolerance = 1e-6; ///< bound of the decrement √(gᵀ(JᵀJ)⁻¹g), in units of the residuals
  /// Makes numbers the same on every rank: last digits of LAPACK's may differ between processors.
  std::function<void(std::span<double>)> agree = [](std::span<double>) {};
};

/// The point reached after an iteration, 0 being the start.
struct GaussNewtonIterate {
  int number = 0;
  std::vector<double> x;
  LeastSquares at;
  double decrement = 0, damping = 0;
};

struct GaussNewtonResult {
  Stop stop;
  GaussNewtonIterate last;
};

/// Minimises ½ |r(x)|² from `start`, an evaluated first guess or an iterate to continue from. `evaluate`
/// returns nothing where a solver fails, which counts as too long a step. `report` is called with every
/// iterate and returns whether to continue.
GaussNewtonResult
gauss_newton(const std::function<std::optional<LeastSquares>(std::span<const double> x)>& evaluate,
             GaussNewtonIterate start, const Box& box, const GaussNewtonOptions& options,
             const std::function<bool(const GaussNewtonIterate&)>& report);

/// Identifiability of the unknowns: JᵀJ as the inverse of a covariance matrix.
struct Identified {
  std::vector<double> deviations;      ///< standard deviation of each unknown; ∞: undetermined by the data
  std::vector<double> correlations;    ///< (n × n)
  std::vector<double> singular_values; ///< descending, for J with columns of length one
  /// Directions x(t) = x + t d that change the residuals by rounding alone; entries that matter little are
  /// zero, the largest is one.
  std::vector<std::vector<double>> unidentified;
};
Identified identified(const std::vector<double>& normal_matrix, std::size_t n);

} // namespace signorini::optimize
