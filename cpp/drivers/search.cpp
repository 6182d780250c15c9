// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/search.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/signals.h"
#include "drivers/coarse_start.h"
#include "drivers/methods.h"
#include "drivers/run_manifest.h"
#include "drivers/search_results.h"
#include <fmt/format.h>
#include <limits>

namespace signorini::drivers {
namespace {

static_assert(optimize::TwiceDifferentiable<control::ReducedProblem>);

/// Requirements of a search on the solvers. A resumed search keeps the linear solver of its checkpoint, since
/// a new choice might differ.
step::Stepper::Needs needs(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                           bool resume) {
  step::Stepper::Needs needs = problem::search_needs(scene);
  const std::string before =
      resume ? io::checkpoint_text(comm, out / resume::checkpoint, SearchLog::solver) : "";
  needs.iterative = scene.solver.linear == scene::LinearMethod::automatic && before == SearchLog::iterative;
  if (!before.empty() && !needs.iterative)
    needs.passes = 0;
  return needs;
}

/// Restores varying step lengths from a checkpoint, if it has any. Throws UserError if this scene does not
/// admit these step lengths.
void restore_steps(problem::Problem& problem, const std::filesystem::path& out) {
  const std::vector<double> levels =
      io::checkpoint_numbers(problem.space.comm(), out / resume::checkpoint, SearchLog::levels);
  if (levels.empty())
    return;
  const step::StepLengths* step_lengths = problem.stepper.step_lengths();
  const std::optional<step::TimeGrid> grid =
      step_lengths ? step::TimeGrid::of_levels(*step_lengths, levels) : std::nullopt;
  if (!grid)
    throw UserError(
        "--resume: the checkpoint has other step lengths than this scene; start the search again, without "
        "--resume");
  problem.grid = *grid;
}

/// Owns the problem of a search and all its parts.
class Searched {
public:
  Searched(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
           Timers& timers, const Console& console)
      : scene_(scene), timers_(timers) {
    if (scene.objective) {
      problem_.emplace(comm, scene, needs(comm, scene, out, resume), timers);
      console.line(headline(*problem_));
      if (resume)
        restore_steps(*problem_, out);
      problem::choose_steps(*problem_, console);
      control_.emplace(*problem_, console);
      discretisation_ = problem_->discretisation;
    } else {
      discretisation_ = std::make_shared<const problem::SpaceDiscretisation>(comm, scene, timers);
    }
    if (scene.unknowns.empty()) {
      if (!scene.measurements.empty())
        console.line("warning: the measurements are not part of J, since the scene has no [[unknown]]");
      return;
    }
    parameters_.emplace(discretisation_, scene, timers, control_ ? &*control_ : nullptr);
    if (!control_)
      console.line(fmt::format("fit of {} unknown{} to {} values of {} measurement{}", scene.unknowns.size(),
                               scene.unknowns.size() == 1 ? "" : "s", parameters_->misfit.count(),
                               scene.measurements.size(), scene.measurements.size() == 1 ? "" : "s"));
    print_table_warnings(parameters_->misfit.warnings(), console);
  }

  [[nodiscard]] SearchSubject subject() {
    return {scene_,
            *discretisation_,
            parameters_ ? parameters_->reduced : control_->reduced,
            timers_,
            problem_ ? &*problem_ : nullptr,
            control_ ? &*control_ : nullptr,
            parameters_ ? &*parameters_ : nullptr};
  }
  /// The control problem; null if only parameters are sought.
  [[nodiscard]] problem::ControlProblem* control() { return control_ ? &*control_ : nullptr; }

private:
  const scene::Scene& scene_;
  Timers& timers_;
  std::shared_ptr<const problem::SpaceDiscretisation> discretisation_;
  std::optional<problem::Problem> problem_;
  std::optional<problem::ControlProblem> control_;
  std::optional<problem::ParameterProblem> parameters_;
};

/// Searches for a control, alone or together with parameters. Starts from the checkpoint, from the result on
/// coarse meshes or from the first guess.
template <template <optimize::TwiceDifferentiable> class Method>
SearchEnd minimised(const SearchSubject& subject, problem::ControlProblem& control, SearchLog& log,
                    const Console& console) {
  const optimize::Options options = search_options(control.controls, subject.scene.optimizer);
  SearchEnd end{};
  SearchStart<Method> start{control.controls.zero()};
  if (subject.parameters) {
    start.guess = {control.first_guess(subject.scene), subject.parameters->misfit.start()};
    subject.reduced.weigh_parameters(start.guess);
  } else if (!log.resumes()) {
    start = search_start<Method>(*subject.problem, control, options, console, end.levels);
  }
  const auto found = optimize::minimize<Method>(subject.reduced, std::move(start.guess), options, log, log,
                                                std::move(start.inherited));
  end.stop = found.stop;
  end.first_norm = found.first_norm;
  return end;
}

/// State of a fit between two iterations, as checkpoints store it. After restoring, J is recomputed.
struct FitState {
  optimize::GaussNewtonIterate& iteration;
  double objective;

  template <class Archive>
  void serialize(Archive& archive) {
    archive("x", iteration.x);
    archive("objective", objective);
    archive("iteration", iteration.number);
    archive("damping", iteration.damping);
    archive("scales", iteration.scales);
  }
};

/// Start of a fit: the parameters of the checkpoint if the search resumes, else the scene's start values.
/// `restored` receives whether the parameters are those of the checkpoint.
optimize::GaussNewtonIterate fit_start(const SearchSubject& subject, SearchLog& log, bool& restored) {
  optimize::GaussNewtonIterate start{.x = subject.parameters->misfit.start(), .at = {}};
  const std::size_t count = start.x.size();
  FitState state{start, 0};
  restored = log.restore(state);
  if (start.x.size() != count || (restored && start.scales.size() != count))
    throw UserError("--resume: the checkpoint's unknowns are damaged; use an undamaged checkpoint");
  start.at = subject.reduced.least_squares(control::Variables(start.x));
  if (restored)
    log.restored(state.objective, start.at.value());
  return start;
}

/// Fits parameters, without a control, by the Gauss-Newton method.
SearchEnd fitted(const SearchSubject& subject, SearchLog& log) {
  const scene::Optimizer& options = subject.scene.optimizer;
  const MPI_Comm comm = subject.comm();
  SearchEnd end{};
  const auto attempt = [&](std::span<const double> x) -> std::optional<optimize::LeastSquares> {
    try {
      return subject.reduced.least_squares(control::Variables(std::vector(x.begin(), x.end())));
    } catch (const UserError& error) { // the scene is invalid at these values
      end.failure = error.what();
    } catch (const SolverFailure& error) {
      end.failure = error.what();
    }
    return std::nullopt;
  };
  bool shown = false;
  optimize::GaussNewtonIterate start = fit_start(subject, log, shown);
  const auto report = [&](const optimize::GaussNewtonIterate& now) {
    end.fitted = now;
    if (!std::exchange(shown, false)) {
      log(now);
      log.mark();
      FitState state{*end.fitted, now.at.value()};
      log.store(state);
    }
    return !stop_requested(comm);
  };
  const auto agree = [comm](std::span<double> numbers) {
    MPI_Bcast(numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, 0, comm);
  };
  try {
    optimize::GaussNewtonResult found = optimize::gauss_newton(
        attempt, std::move(start), subject.parameters->misfit.box(),
        {.max_iterations = options.max_iterations, .tolerance = *options.tolerance, .agree = agree}, report);
    end.stop = found.stop;
    end.fitted = std::move(found.last);
  } catch (const Interrupted&) {
    if (!end.fitted)
      throw;
    end.stop = optimize::Stop::interrupted;
  }
  return end;
}

SearchEnd search(Searched& searched, SearchLog& log, const Console& console) {
  const SearchSubject subject = searched.subject();
  problem::ControlProblem* control = searched.control();
  if (!control)
    return fitted(subject, log);
  return with_method(subject.scene.optimizer.method,
                     [&]<template <optimize::TwiceDifferentiable> class Method>() {
                       return minimised<Method>(subject, *control, log, console);
                     });
}

} // namespace

void require_control_problem(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out) {
  if (!scene.objective)
    throw UserError(
        fmt::format("{}: optimize needs the tables [control] and [objective], but the scene has {}",
                    scene.file.string(), scene.control ? "no objective" : "neither"));
  if (const auto* run = std::get_if<scene::DesiredRun>(&scene.objective->desired))
    on_root(comm, [&] {
      std::error_code missing;
      if (std::filesystem::equivalent(out, run->folder, missing))
        throw UserError(fmt::format("--out: {} is the folder of objective.desired.run, whose files this run "
                                    "would replace; choose another folder",
                                    run->folder.string()));
    });
}

optimize::Options search_options(const control::ControlSpace& controls, const scene::Optimizer& scene) {
  constexpr double usual_bytes = 1e8, usual_controls = 128, least_controls = 16;
  const double each = controls.compact_bytes(), usual = std::max(usual_bytes, usual_controls * each),
               memory = scene.memory > 0 ? scene.memory : usual;
  if (memory < least_controls * each)
    throw UserError(fmt::format("optimizer.memory: found {:.10g} bytes; expected at least the memory of {} "
                                "controls in single precision, {:.10g} bytes",
                                memory, least_controls, least_controls * each));
  optimize::Options options{.max_iterations = scene.max_iterations,
                            .tolerance = *scene.tolerance,
                            .vectors = static_cast<std::size_t>(memory / each)};
  options.bundle.dependent = 10 * std::numeric_limits<float>::epsilon(); // vectors are in single precision
  return options;
}

int search_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
                 const Console& console) {
  if (scene.objective || scene.unknowns.empty())
    require_control_problem(comm, scene, out);
  io::OutputFolder folder(comm, out, resume ? resume::checkpoint : "");
  Timers timers;
  Searched searched(comm, scene, out, resume, timers, console);
  SearchLog log(searched.subject(), folder, resume, console);
  SearchEnd end = search(searched, log, console);
  log.end();
  if (!log.evaluated()) // rows of a checkpoint alone are no result
    throw Interrupted();
  const optimize::Stop stop = end.stop;
  write_results(folder, log, std::move(end), console);
  return stop == optimize::Stop::solver_failed ? exit_status::solver_failed
         : stop == optimize::Stop::interrupted ? exit_status::interrupted
                                               : exit_status::done;
}

} // namespace signorini::drivers
