// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/simulate_to_accuracy.h"
#include "accuracy/error_estimate.h"
#include "accuracy/grading.h"
#include "accuracy/trials.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/signals.h"
#include <fmt/format.h>

namespace signorini::accuracy {
namespace {

/// Temporary folder, which the destructor removes; the path is available on every rank. Collective.
class ScratchFolder {
public:
  explicit ScratchFolder(MPI_Comm comm) : comm_(comm) {
    std::string name;
    on_root(comm, [&] {
      name = (std::filesystem::temp_directory_path() / "signorini-XXXXXX").string();
      if (!mkdtemp(name.data()))
        throw WriteFailure(fmt::format("{}: this temporary folder cannot be created; set TMPDIR to a "
                                       "writable folder",
                                       name));
    });
    path_ = broadcast(comm, name);
  }
  ~ScratchFolder() {
    std::error_code left;
    if (rank(comm_) == 0)
      std::filesystem::remove_all(path_, left);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
  MPI_Comm comm_;
  std::filesystem::path path_;
};

} // namespace

int simulate_to_accuracy(MPI_Comm comm, scene::Scene scene, const std::filesystem::path& out,
                         const AccuracyAsked& asked, drivers::SimulateOptions how, const Console& console) {
  if (scene.mesh.automatic())
    require_estimable(scene, "--accuracy with mesh.size = \"auto\"", "give mesh.size");
  const Elapsed elapsed(comm);
  if (asked.budget)
    stop_after(*asked.budget);
  std::optional<ScratchFolder> scratch;
  // With the given control: an objective has no effect.
  scene::Scene simulated = scene;
  simulated.objective.reset();
  if (scene.mesh.automatic()) { // from now on at a scale of sizes that vary
    const std::filesystem::path graded = scratch.emplace(comm).path() / "graded.geo";
    write_graded(comm, simulated, graded, console);
    for (scene::Scene* one : {&scene, &simulated}) {
      one->mesh.file = graded;
      one->mesh.size.reset();
    }
  }
  how.keep_mesh = scratch.has_value();
  const auto keep = [&](const TrialRun& found) {
    how.accuracy = io::Accuracy{.quantity = asked.quantities.front(),
                                .asked = asked.error,
                                .space = found.space,
                                .time = found.time,
                                .met = found.meets(asked.error),
                                .warning = found.warning};
    (void)drivers::simulate_scene(comm, on_rung(scene, found.rung), out, how, Console(false, false));
    how.replace = true; // from now on it is this run's own
    how.complete_only = true;
  };
  const std::unique_ptr<TrialRuns> trials =
      study_trials(comm, simulated, asked.quantities, "--accuracy", console, keep);
  Refinement refinement(*trials, asked.error, asked.budget, elapsed, console);
  return refine_to_accuracy(comm, refinement, *trials, asked, out, console);
}

} // namespace signorini::accuracy
