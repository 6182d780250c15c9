// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/report.h"
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <vector>

/// Nonlinear least squares with few unknowns, min ½ |r(x)|² over lower ≤ x ≤ upper, by Gauss-Newton steps
/// with the damping of Levenberg and Marquardt.
namespace signorini::optimize {

/// Residuals r at a point (m entries) and their Jacobian J (m × n, column by column).
struct LeastSquares {
  std::vector<double> residuals, jacobian;

  /// Returns ½ |r|².
  [[nodiscard]] double value() const;
  /// Number of unknowns n.
  [[nodiscard]] std::size_t columns() const {
    return residuals.empty() ? 0 : jacobian.size() / residuals.size();
  }
  /// Returns the gradient Jᵀr (n entries).
  [[nodiscard]] std::vector<double> gradient() const;
  /// Returns the normal matrix JᵀJ (n × n).
  [[nodiscard]] std::vector<double> normal_matrix() const;
};

/// Bounds of the unknowns (±∞: none) and limits of their changes in one step.
struct Box {
  std::vector<double> lower, upper;
  /// Largest change of each unknown in one step, beyond which the linearised residuals have no meaning;
  /// empty: no limits.
  std::vector<double> longest = {};

  /// Returns whether unknown i, with value x, is at a bound and the descent direction −g points out of it.
  [[nodiscard]] bool blocks(std::size_t i, double x, double g) const {
    return (x <= lower[i] && g > 0) || (x >= upper[i] && g < 0);
  }
  /// Returns whether one step may change unknown i from x to `next`.
  [[nodiscard]] bool reaches(std::size_t i, double x, double next) const {
    return longest.empty() || std::abs(next - x) <= longest[i];
  }
  /// Returns the value nearest to `wanted` to which one step may change unknown i from x, within the bounds.
  [[nodiscard]] double nearest(std::size_t i, double x, double wanted) const {
    if (!reaches(i, x, wanted))
      wanted = x + std::copysign(longest[i], wanted - x);
    return std::clamp(wanted, lower[i], upper[i]);
  }
};

struct GaussNewtonOptions {
  int max_iterations = 100;
  double tolerance = 1e-6; ///< limit of the decrement √(gᵀ(JᵀJ)⁻¹g), in units of the residuals
  /// Function that makes numbers equal on all ranks, since last digits of LAPACK's results may differ between
  /// processors.
  std::function<void(std::span<double>)> agree = [](std::span<double>) {};
};

/// Point reached after iteration `number`; 0 is the start.
struct GaussNewtonIterate {
  int number = 0;
  std::vector<double> x;
  LeastSquares at;
  double decrement = 0, damping = 0;
  /// Largest diagonal of JᵀJ so far, which the damping multiplies; set by the search.
  std::vector<double> scales{};
};

struct GaussNewtonResult {
  Stop stop;
  GaussNewtonIterate last;
};

/// Minimises ½ |r(x)|² from `start`, which is an evaluated first guess or an iterate from which to continue.
/// `evaluate` returns nothing if a solver fails, which counts as too long a step. `report` is called with
/// every iterate and returns whether to continue.
GaussNewtonResult
gauss_newton(const std::function<std::optional<LeastSquares>(std::span<const double> x)>& evaluate,
             GaussNewtonIterate start, const Box& box, const GaussNewtonOptions& options,
             const std::function<bool(const GaussNewtonIterate&)>& report);

/// Identifiability of the unknowns, with JᵀJ taken as the inverse of their covariance matrix.
struct Identified {
  std::vector<double> deviations;      ///< standard deviation of each unknown; ∞: not determined by the data
  std::vector<double> correlations;    ///< correlations of the unknowns (n × n)
  std::vector<double> singular_values; ///< singular values of J with columns scaled to length one, descending
  /// Directions d along which x + t d changes the residuals by no more than rounding. Entries below 1e-4 of
  /// the largest are set to zero; the largest entry is one.
  std::vector<std::vector<double>> unidentified;
};
/// Returns the identifiability of n unknowns from their normal matrix JᵀJ (n × n).
Identified identified(const std::vector<double>& normal_matrix, std::size_t n);

} // namespace signorini::optimize
