// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/refinement_loop.h"
#include <functional>
#include <memory>

namespace signorini::accuracy {

/// Callback that stores a run which is better than all before.
using KeepTrial = std::function<void(const TrialRun&)>;

/// Returns an object that makes trial runs and estimates the error of the one quantity in `names`, by default
/// J. The error of J is the adjoint estimate from the run itself. The error of another quantity is the error
/// bar from the rung and four coarser rungs, with twice and four times its size or its step; these four
/// together take about as long as the rung. `option`: option of the command line, for messages. `keep`:
/// called with each run that is better than all before it; for quantities other than J first with a coarse
/// run whose error is not estimated. Throws UserError. Collective. `scene` must outlive the result.
std::unique_ptr<TrialRuns> study_trials(MPI_Comm comm, const scene::Scene& scene,
                                        const std::vector<std::string>& names, const char* option,
                                        const Console& console, KeepTrial keep = {});

} // namespace signorini::accuracy
