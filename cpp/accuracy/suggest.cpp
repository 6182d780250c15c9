// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/study.h"
#include "accuracy/trials.h"
#include <fmt/format.h>

namespace signorini::accuracy {

int suggest(MPI_Comm comm, const scene::Scene& scene, double tolerance, const Options& options,
            const Console& console) {
  constexpr double usual_budget = 600; // s, as in --help
  const std::unique_ptr<TrialRuns> trials =
      study_trials(comm, scene, options.quantities, "--suggest", console);
  const Elapsed elapsed(comm);
  Refinement refinement(*trials, tolerance, options.budget.value_or(usual_budget), elapsed, console);
  refinement.run(true);
  const TrialRun& found = *refinement.best();
  console.line(fmt::format("a relative error of {:g} in {} is {}: {}, {}, run time {:.2g} s; this suggestion "
                           "took {:.2g} s\nin the scene: {}",
                           tolerance, trials->title(),
                           refinement.met()        ? "met by"
                           : found.warning.empty() ? "not met; the best run is"
                                                   : "not verified (" + found.warning + "); the best run is",
                           trials->words(found.rung), found.grounds, found.seconds, elapsed.seconds(),
                           keys(found.rung, scene)));
  return refinement.met() ? 0 : 1;
}

} // namespace signorini::accuracy
