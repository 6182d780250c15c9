#pragma once
#include "forward/step.h"
#include <array>

namespace signorini::forward {

/// Guesses the next of a series of solutions from the last three, by the parabola through them; does nothing
/// where the stepper's solver takes no guess.
class Extrapolation {
public:
  explicit Extrapolation(const Stepper& stepper);

  void remember(Vec x);
  /// Leaves `out` as it is before anything was remembered.
  void guess(Vec out) const;

  void forget() { known_ = 0; }
  /// Goes on as `other` would.
  void take(const Extrapolation& other);

  /// Vectors that it keeps.
  static int vectors(const Stepper& stepper) { return stepper.solver().takes_guess() ? most : 0; }

private:
  static constexpr int most = 3;
  bool wanted_;
  std::array<petsc::Vector, most> last_; ///< the latest first
  int known_ = 0;
};

} // namespace signorini::forward
