// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"

namespace signorini::drivers {

/// Components of a smooth field at points (n × 3) and relative time t/T in `t`, in `out` (n × components),
/// the same on any number of ranks; `which` selects one of several fields.
void wave(const fem::Space& space, const std::vector<double>& points, const std::vector<int>& components,
          double t, int which, std::span<double> out);

/// A smooth control, by the same fields. Collective.
control::Control wave(const control::ControlSpace& controls, int which);

/// The control at which derivatives and errors are evaluated: the scene's [check] control, else one near the
/// reference control (at the reference itself the tracking error and with it the adjoint vanish), else the
/// first guess; the same function of place and time on every mesh. `description` receives which. Collective.
/// Throws UserError.
control::Control evaluation_point(const problem::Problem& problem,
                                  const problem::ControlProblem& control_problem, std::string& description);

} // namespace signorini::drivers
