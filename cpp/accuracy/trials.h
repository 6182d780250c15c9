// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/refinement_loop.h"
#include <functional>
#include <memory>

namespace signorini::accuracy {

/// What is done with a run that is better than all before.
using KeepTrial = std::function<void(const TrialRun&)>;

/// Trial runs of J or of the one quantity in `names`, which the command line asked for by `option`. The error
/// of J is what the adjoint estimates from the run itself. That of another quantity is the error bar of a
/// rung beside two coarser ones in size and two in step, with twice and four times either; they take about as
/// long as the rung once more. With `keep`, a coarse rung whose error is not known is kept first. `scene`
/// must outlive the result. Collective. Throws UserError.
std::unique_ptr<TrialRuns> study_trials(MPI_Comm comm, const scene::Scene& scene,
                                        const std::vector<std::string>& names, const char* option,
                                        const Console& console, KeepTrial keep = {});

} // namespace signorini::accuracy
