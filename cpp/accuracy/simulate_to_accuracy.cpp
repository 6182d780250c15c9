// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/simulate_to_accuracy.h"
#include "accuracy/grading.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/signals.h"
#include <chrono>
#include <fmt/format.h>

namespace signorini::accuracy {
namespace {

/// A folder that is gone with this object; its name is known on every rank. Collective.
class ScratchFolder {
public:
  explicit ScratchFolder(MPI_Comm comm) : comm_(comm) {
    std::string name;
    on_root(comm, [&] {
      name = (std::filesystem::temp_directory_path() / "signorini-XXXXXX").string();
      if (!mkdtemp(name.data()))
        throw WriteFailure(fmt::format("{}: the folder cannot be made", name));
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

int simulate_to_accuracy(MPI_Comm comm, scene::Scene scene, const std::filesystem::path& out, double asked,
                         const Options& options, drivers::SimulateOptions how, const Console& console) {
  const auto start = std::chrono::steady_clock::now();
  if (options.budget)
    stop_after(*options.budget);
  BestRun best;
  bool stopped = false, answered = false;
  std::optional<ScratchFolder> scratch;
  if (scene.mesh.automatic()) { // from now on at a scale of sizes that vary
    scene::Scene simulated = scene;
    simulated.objective.reset();
    const std::filesystem::path graded = scratch.emplace(comm).path() / "graded.geo";
    write_graded(comm, simulated, graded, console);
    scene.mesh.file = graded;
    scene.mesh.size.reset();
  }
  how.keep_mesh = scratch.has_value();
  const auto write = [&](const BestRun& found) {
    how.accuracy = io::Accuracy{.quantity = options.quantities.front(),
                                .asked = asked,
                                .space = found.space,
                                .time = found.time,
                                .met = found.meets(asked),
                                .warning = found.warning};
    how.whole = answered;
    (void)drivers::simulate_scene(comm, on_rung(scene, found.rung), out, how, Console(false, false));
    how.replace = true; // from now on it is this run's own
    best = found;
    answered = true;
  };
  try {
    (void)find_size_and_step(comm, scene, asked, options, console, write);
  } catch (const Interrupted&) {
    if (!answered)
      throw;
    stopped = true;
  }
  const bool late = time_is_up(comm), met = best.meets(asked);
  forget_deadline();
  double passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  MPI_Bcast(&passed, 1, MPI_DOUBLE, 0, comm);
  const std::string asked_for = fmt::format("{:g} of {} asked", asked, options.quantities.front()),
                    end = met                    ? std::string("met")
                          : stopped && !late     ? "not met, interrupted"
                          : late                 ? "not met, the budget is spent"
                          : best.warning.empty() ? "not met"
                                                 : "not verified, " + best.warning,
                    resolution = words(best.rung, scene);
  if (best.seconds == 0) // the first of all
    console.line(fmt::format("{}, no error estimate yet: {}; {}, {:.2g} s in all", asked_for, end, resolution,
                             passed));
  else
    console.line(fmt::format(
        "{}, {:.2e} estimated (space {:.1e}, time {:.1e}): {}; {}, {:.2g} s in all, of which the run "
        "took {:.2g} s; {} would take about {:.2g} s",
        asked_for, best.error(), best.space, best.time, end, resolution, passed, best.seconds,
        best.error() > asked ? "what is asked" : "half the error", best.further));
  console.line(fmt::format("results in {}", out.string()));
  return met ? exit_status::done : stopped && !late ? exit_status::interrupted : exit_status::check_failed;
}

} // namespace signorini::accuracy
