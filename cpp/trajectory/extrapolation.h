// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/dense.h"
#include "step/step.h"
#include <algorithm>
#include <array>

namespace signorini::trajectory {

/// Guesses the next solution of a series: by the parabola through the last three and, while steps are equal,
/// by the parabola's error, predicted from its errors at up to five earlier solutions. The prediction is
/// autoregressive: e_k ≈ Σ_j w_j e_{k−j} with weights that fit the latest error best, so that motions of a
/// few frequencies are guessed almost exactly. Does nothing if the stepper's solver takes no guess.
class Extrapolation {
public:
  explicit Extrapolation(const step::Stepper& stepper);

  /// Stores the latest solution `x`, at time `t` (s), unless the solution stored last has the same time.
  /// Times must be monotone. Collective.
  void remember(double t, Vec x);
  /// Sets `out` to the solution extrapolated to time `t` (s); leaves it unchanged if nothing is stored.
  void guess(double t, Vec out) const;

  /// Discards all stored solutions.
  void forget() { known_ = equal_ = weights_ = 0; }
  /// Copies everything that is stored in `other`: guesses from now on equal its guesses to the last bit.
  void take(const Extrapolation& other);

  /// Returns the number of vectors that an extrapolation for this stepper stores.
  static int vectors(const step::Stepper& stepper) { return stepper.solver().takes_guess() ? stored : 0; }

private:
  static constexpr int points = 3;        ///< solutions that determine a parabola
  static constexpr int errors = 5;        ///< stored errors of parabolas
  static constexpr int lags = errors - 1; ///< largest number of weights
  static constexpr int stored = points + errors;

  /// Whether a step to time `t` is as long as the step before it.
  [[nodiscard]] bool continues(double t) const;
  /// Number of stored errors: the first three of a series of equal steps have none.
  [[nodiscard]] int known_errors() const { return std::clamp(equal_ - points + 1, 0, errors); }
  /// Computes the products of the latest error with all stored ones.
  void update_products();
  /// Computes the weights from the products of the errors.
  void fit_weights();

  bool wanted_;
  /// The latest solution; its divided differences of first and second order; errors, the latest first.
  std::array<petsc::Vector, stored> stored_;
  std::array<double, points> times_{}; ///< times of the last solutions, the latest first, s
  int known_ = 0;                      ///< number of solutions that the parabola passes through
  int equal_ = 0;                      ///< number of the last steps that had the same length
  std::array<std::array<double, errors>, errors> products_{}; ///< inner products of the errors, i ≤ j
  std::array<double, lags> w_{};
  int weights_ = 0;              ///< number of weights in w_; 0: the parabola alone
  UpdatedCholesky normal_{lags}; ///< scratch of fit_weights()
};

} // namespace signorini::trajectory
