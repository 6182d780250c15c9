// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"

namespace signorini::drivers {

/// Evaluates components of a smooth test field at points (n × 3), m, into `out` (n × components). `t`: time,
/// relative to the duration of the motion; `which`: number of the field. The fields do not depend on the
/// number of ranks.
void wave(const fem::Space& space, const std::vector<double>& points, const std::vector<int>& components,
          double t, int which, std::span<double> out);

/// Control with the values of the smooth test field number `which`. Collective.
control::Control wave(const control::ControlSpace& controls, int which);

/// Control at which derivatives and errors are evaluated: the control of the scene's table [check], else a
/// control near the reference control, else the first guess. The reference control itself is not used, since
/// its tracking error and adjoint vanish. On every mesh the result is the same function of place and time.
/// `description` receives the choice in words. Throws UserError. Collective.
control::Control evaluation_point(const problem::Problem& problem,
                                  const problem::ControlProblem& control_problem, std::string& description);

} // namespace signorini::drivers
