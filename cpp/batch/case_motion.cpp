// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/case_motion.h"
#include "base/error.h"
#include "diagnostics/plausibility.h"
#include "diagnostics/warnings.h"
#include "drivers/run_manifest.h"
#include <algorithm>

namespace signorini::batch {

std::vector<accuracy::Quantity> case_quantities(const scene::Scene& scene,
                                                const std::vector<std::string>& names, int dim) {
  std::vector<accuracy::Quantity> all = accuracy::quantities(scene, dim);
  std::erase_if(all, &accuracy::Quantity::field);
  if (!names.empty())
    return accuracy::named(all, names, "numbers");
  std::erase_if(all, [](const accuracy::Quantity& one) {
    return one.name == "energy_loss" || one.name == accuracy::of_stress ||
           one.name == accuracy::of_restitution;
  });
  return all;
}

CaseMotion::CaseMotion(std::shared_ptr<const problem::SpaceDiscretisation> discretisation,
                       const scene::Scene& scene, const std::vector<std::string>& quantities,
                       const CaseMotion* like)
    : scene_(scene), problem_(std::move(discretisation), scene_, problem::simulation_needs(scene_), timers_,
                              trajectory::Stops::obeyed, like ? &like->problem_ : nullptr),
      given_(problem_), wanted_(case_quantities(scene_, quantities, problem_.space.dim())) {}

Outcome CaseMotion::run(const std::filesystem::path* folder) {
  try {
    return motion(folder);
  } catch (const Interrupted&) {
    return {.reason = "interrupted", .interrupted = true};
  } catch (const UserError& error) {
    return {.reason = error.what()};
  } catch (const SolverFailure& error) {
    return {.reason = error.what()};
  }
}

namespace {

/// Collects the warnings that a motion leaves the range of the model or that the mesh does not resolve it.
class ModelWarnings {
public:
  explicit ModelWarnings(const problem::Problem& problem)
      : plausibility_(problem.stepper, problem.scene, parts), resolution_(problem.stepper, problem.scene),
        forces_(problem.stepper) {}

  void observe(const trajectory::Frame& frame) {
    forces_.observe(frame);
    resolution_.observe(frame, forces_);
    plausibility_.observe(frame, nullptr);
  }

  /// Adds the warnings to those of the steps, `found`, and returns the first message of each kind.
  [[nodiscard]] std::map<std::string, std::string> by_kind(std::vector<Warning> found) {
    std::ranges::move(plausibility_.warnings(), std::back_inserter(found));
    std::ranges::move(resolution_.warnings(), std::back_inserter(found));
    std::map<std::string, std::string> first;
    for (const Warning& one : found)
      first.try_emplace(one.name, one.message);
    return first;
  }

private:
  // Strains of every cell take as long as several steps of many motions together.
  static constexpr int parts = 4;

  diagnostics::Plausibility plausibility_;
  diagnostics::ContactResolution resolution_;
  diagnostics::ObstacleForces forces_;
};

/// Folder with the results of a motion, and their writer.
class Recording {
public:
  Recording(const problem::Problem& problem, bool controlled, const std::filesystem::path& out)
      : problem_(problem), folder_(MPI_COMM_SELF, out), writer_(problem, folder_, nullptr, controlled) {}

  void observe(const trajectory::Frame& frame) { writer_(frame); }

  void publish(const std::optional<control::ObjectiveValue>& objective) {
    const Console silent(false, false);
    writer_.finish();
    folder_.write("scene.toml", scene::echo(problem_.scene, problem_.space.dim()));
    io::Manifest m = drivers::manifest(problem_, "simulate", "end of time", problem_.steps());
    drivers::add_watched(m, writer_, problem_.scene.run, silent);
    m.objective = objective;
    m.files = folder_.files();
    folder_.write("run.json", io::to_json(m, problem_.scene, problem_.timers));
    drivers::finish(folder_, silent);
  }

private:
  const problem::Problem& problem_;
  io::OutputFolder folder_;
  drivers::MotionWriter writer_;
};

} // namespace

Outcome CaseMotion::motion(const std::filesystem::path* folder) {
  std::optional<Recording> recording;
  if (folder)
    recording.emplace(problem_, given_.acts(), *folder);
  accuracy::MotionQuantities quantities(problem_, wanted_, nullptr);
  ModelWarnings warnings(problem_);
  std::optional<problem::RunObjective> objective;
  if (scene_.objective && accuracy::has(wanted_, "J"))
    objective.emplace(problem_, given_);
  std::optional<ProbeFigures> probes;
  if (problem_.probes)
    probes.emplace(problem_, given_.acts());
  accuracy::simulate(problem_, given_.load(), [&](const trajectory::Frame& frame) {
    quantities(frame);
    warnings.observe(frame);
    if (objective)
      objective->observe(frame);
    if (probes)
      probes->observe(frame);
    if (recording)
      recording->observe(frame);
  });
  accuracy::Measured measured;
  quantities.report(measured);
  std::optional<control::ObjectiveValue> J;
  if (objective) {
    J = objective->value();
    measured.numbers["J"] = J->total();
  }
  if (recording)
    recording->publish(J);
  Outcome outcome{.steps = problem_.steps(), .warnings = warnings.by_kind(measured.warnings)};
  for (const accuracy::Quantity& one : wanted_)
    if (const auto found = measured.numbers.find(one.name); found != measured.numbers.end())
      outcome.numbers.emplace_back(one.name, found->second);
  if (probes)
    std::ranges::move(probes->numbers(), std::back_inserter(outcome.numbers));
  return outcome;
}

} // namespace signorini::batch
