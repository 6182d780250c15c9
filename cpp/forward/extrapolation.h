#pragma once
#include "base/petsc.h"
#include <array>

namespace signorini::forward {

/// Guesses the next of a series of solutions from the last three, by the parabola through them.
class Extrapolation {
public:
  explicit Extrapolation(Vec layout);

  void remember(Vec x);
  /// Leaves `out` as it is before anything was remembered.
  void guess(Vec out) const;

private:
  std::array<petsc::Vector, 3> last_; ///< the latest first
  int known_ = 0;
};

} // namespace signorini::forward
