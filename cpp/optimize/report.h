// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/certificate.h"
#include <string>

namespace signorini::optimize {

/// Stopping reasons of a search.
enum class Stop {
  gradient_tolerance,
  kink,
  iteration_limit,
  no_decrease,
  solver_failed,
  interrupted,
  short_steps,
  enough
};

inline std::string name(Stop stop) {
  switch (stop) {
  case Stop::gradient_tolerance:
    return "gradient norm below tolerance";
  case Stop::kink:
    return "stationary at a kink";
  case Stop::iteration_limit:
    return "iteration limit";
  case Stop::no_decrease:
    return "no further decrease: the predicted one is below rounding (at a minimiser or a kink of J)";
  case Stop::solver_failed:
    return "solver failed in every trial step";
  case Stop::interrupted:
    return "interrupted";
  case Stop::short_steps:
    return "short steps, as among kinks";
  case Stop::enough:
    return "accurate enough";
  }
  return "unknown";
}

/// How a search ended.
template <class Vector>
struct Result {
  Stop stop;
  std::optional<Certificate<Vector>> certificate = std::nullopt; ///< at a kink
  double first_norm = 0; ///< the gradient norm of which Options::tolerance is a part
};

/// The record of one iteration.
struct Iteration {
  int number = 0;
  double objective = 0;
  double gradient_norm = 0; ///< ‖u − P(u − s g)‖/s with s of the search's Units; without bounds ‖g‖
  /// Multiple taken of the direction; projected-gradient: of the problem's gradient; 0 at the first guess.
  double step_length = 0;
  /// What the model of the method promised of J for the last step, of a quadratic one -g·d/2: about the
  /// distance from a minimiser. Infinite if it has none. Not stored.
  double promised = std::numeric_limits<double>::infinity();

  template <class Archive>
  void serialize(Archive& archive) {
    archive("iteration/number", number);
    archive("iteration/objective", objective);
    archive("iteration/gradient_norm", gradient_norm);
    archive("iteration/step_length", step_length);
  }
};

} // namespace signorini::optimize
