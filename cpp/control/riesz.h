// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control_space.h"

namespace signorini::control {

/// Returns the control r with inner(r, ·) = d, up to rounding: the inverse of ControlSpace::dual().
/// Collective. Throws SolverFailure.
[[nodiscard]] Control riesz_representative(const ControlSpace& controls, const Control& d);

} // namespace signorini::control
