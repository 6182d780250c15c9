// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/refinement_loop.h"
#include <functional>
#include <memory>

namespace signorini::accuracy {

/// Callback for a run that is better than all before.
using KeepTrial = std::function<void(const TrialRun&)>;

/// Trial runs of J or of the one quantity in `names`, which the command line requested by `option`. The error
/// of J is the adjoint's estimate from the run itself. That of another quantity is the error bar of a rung
/// beside four coarser ones, with twice and four times its size and its step. These together take about as
/// long as the rung. With `keep`, a coarse rung whose error is not known is kept first. `scene` must outlive
/// the result. Collective. Throws UserError.
std::unique_ptr<TrialRuns> study_trials(MPI_Comm comm, const scene::Scene& scene,
                                        const std::vector<std::string>& names, const char* option,
                                        const Console& console, KeepTrial keep = {});

} // namespace signorini::accuracy
