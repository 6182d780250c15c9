// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "io/output_folder.h"
#include "problem/problem.h"
#include <functional>

namespace signorini::drivers {

/// Shows adjoint states, each valid during the call of `store`.
using AdjointStates = std::function<void(const std::function<void(int k, Vec p)>& store)>;

/// Writes control.xdmf and adjoint.xdmf of those steps of which the motion is `stored`, as far as the scene's
/// [output] asks for them; only then are adjoint states asked for. Collective. Throws UserError,
/// WriteFailure.
void write_control(const io::OutputFolder& folder, const problem::Problem& problem,
                   const control::ControlSpace& controls, const control::Control& u,
                   const AdjointStates& adjoint_states, const std::vector<int>& stored);

} // namespace signorini::drivers
