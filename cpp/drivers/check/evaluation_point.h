// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"

namespace signorini::drivers {

/// Evaluates components of a smooth field at points (n × 3) and the relative time `t` = t/T into `out` (n ×
/// components). `which` selects one of several fields, the same on any number of ranks.
void wave(const fem::Space& space, const std::vector<double>& points, const std::vector<int>& components,
          double t, int which, std::span<double> out);

/// Control whose values are those of a smooth field, selected by `which`. Collective.
control::Control wave(const control::ControlSpace& controls, int which);

/// Control at which derivatives and errors are evaluated: the scene's [check] control, else one near the
/// reference control, else the first guess. At the reference itself the tracking error and the adjoint
/// vanish. It is the same function of place and time on every mesh. `description` receives the choice.
/// Collective. Throws UserError.
control::Control evaluation_point(const problem::Problem& problem,
                                  const problem::ControlProblem& control_problem, std::string& description);

} // namespace signorini::drivers
