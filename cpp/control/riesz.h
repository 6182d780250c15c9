// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control_space.h"

namespace signorini::control {

/// The inverse of ControlSpace::dual(): the control r with inner(r, ·) = d, to rounding. Collective. Throws
/// SolverFailure.
[[nodiscard]] Control riesz_representative(const ControlSpace& controls, const Control& d);

} // namespace signorini::control
