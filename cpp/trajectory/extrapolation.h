// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/step.h"
#include <array>

namespace signorini::trajectory {

/// Extrapolates a series of solutions by the parabola through the last three, as a guess of the next one;
/// does nothing where the stepper's solver takes no guess.
class Extrapolation {
public:
  explicit Extrapolation(const step::Stepper& stepper);

  /// Stores a copy of the latest solution, of time `t` (s), unless it is known already.
  void remember(double t, Vec x);
  /// Sets `out` to the extrapolated solution of time `t`; leaves it unchanged if nothing is remembered.
  void guess(double t, Vec out) const;

  void forget() { known_ = 0; }
  /// Copies what `other` remembers.
  void take(const Extrapolation& other);

  /// Number of vectors that an object stores.
  static int vectors(const step::Stepper& stepper) { return stepper.solver().takes_guess() ? most : 0; }

private:
  static constexpr int most = 3;
  bool wanted_;
  std::array<petsc::Vector, most> last_; ///< the latest first
  std::array<double, most> times_{};     ///< of these
  int known_ = 0;
};

} // namespace signorini::trajectory
