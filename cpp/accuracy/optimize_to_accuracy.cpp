// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/optimize_to_accuracy.h"
#include "accuracy/error_estimate.h"
#include "accuracy/grading.h"
#include "accuracy/quantities.h"
#include "base/signals.h"
#include "drivers/methods.h"
#include "drivers/run_manifest.h"
#include "drivers/search.h"
#include "drivers/search_level.h"
#include "drivers/search_results.h"
#include "mesh/size_field.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::accuracy {
namespace {

/// Largest acceptable error estimate, relative to the requested error, since the true error may be twice the
/// estimate (docs/method.md section 7).
constexpr double trusted = 0.5;
/// Error that a search may leave, relative to the largest acceptable error estimate.
constexpr double search_part = 0.05;
/// Lower bound for the iteration limit of a search, which stops when the gains become small.
constexpr int most_iterations = 1000;
/// Multiples of the scene's size and step for the first run; the first multiple that can be run is used.
constexpr std::array beginnings{4.0, 2.0, 1.0};
constexpr int least_steps = 10;

/// Trial runs that search for the optimum; each search starts from the result of the previous one.
template <template <optimize::TwiceDifferentiable> class Method>
class SearchTrials final : public TrialRuns {
public:
  SearchTrials(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, double error,
               const Elapsed& elapsed, const Console& console)
      : comm_(comm), scene_(scene), out_(out), error_(error), elapsed_(elapsed), console_(console) {}

  /// Range of predictions. It is short, since the estimate on a coarse mesh predicts little of a much finer
  /// one.
  [[nodiscard]] Reach reach() const override { return {.order = 2, .finer = 3, .coarser = 1}; }
  [[nodiscard]] int dim() const override { return level_->problem().mesh.dim(); }

  [[nodiscard]] std::vector<Rung> first_rungs() const override {
    std::vector<Rung> rungs;
    for (const double multiple : accuracy::beginnings) {
      Rung rung = own_rung(scene_);
      rung.size = sizes_vary() ? 1 : multiple * rung.size;
      rungs.push_back(nearest(rung.with_steps(multiple)));
    }
    return rungs;
  }

  [[nodiscard]] Rung nearest(const Rung& rung) const override {
    Rung next = rung;
    if (!rung.has_varying_steps())
      next.steps = std::max(least_steps, rung.steps);
    return next;
  }

  /// Extrapolates the seconds of the last run, with a margin, since a finer problem may take more iterations.
  [[nodiscard]] double seconds(const Rung& rung) override {
    constexpr double iterations = 1.4;
    return iterations * row_.seconds * work(rung, dim()) / work(rung_, dim());
  }

  [[nodiscard]] std::string words(const Rung& rung) const override {
    if (!sizes_vary())
      return accuracy::words(rung, scene_);
    return fmt::format("element sizes {:.2g} times those of round 1, {}", rung.size,
                       words_of_step(rung, scene_));
  }

  TrialRun run(const Rung& rung) override {
    const Elapsed elapsed(comm_);
    log_.reset();
    folder_.reset(); // releases its lock, which the next one needs
    folder_.emplace(comm_, out_, drivers::resume::checkpoint);
    scene::Scene scene = on_rung(scene_, rung);
    mesh::Meshing meshing;
    std::optional<mesh::SizeField> sizes;
    if (sizes_vary())
      scene.mesh = scene_.mesh;
    written_ = scene;
    if (sizes_vary()) {
      if (level_) {
        const double part = rung.size / rung_.size;
        sizes = mesh::sizes_by(level_->problem().mesh, by_cells_, part * part, reach().finer);
        meshing.sizes = &*sizes;
      }
      drivers::keep_mesh(*folder_, meshing, written_);
    }
    auto level = std::make_unique<drivers::SearchLevel<Method>>(comm_, scene, meshing, level_.get(),
                                                                problem::search_needs(scene_));
    const problem::Problem& problem = level->problem();
    problem::ControlProblem& control_problem = level->control_problem();
    const drivers::SearchSubject subject{
        written_, *problem.discretisation, control_problem.reduced, problem.timers,
        &problem, &control_problem};
    log_.emplace(subject, *folder_, false, console_, drivers::SearchLog::Files::with_results);
    TrialRun trial{.rung = rung};
    trial.search = search(*level);
    log_->end();
    const double J = std::abs(control_problem.reduced.value().total());
    if (!(J > 0))
      throw UserError(
          "--accuracy: J is 0 at the optimum, so relative errors are undefined; choose another objective");
    const adjoint::ErrorParts error = estimate_error(problem, control_problem, &by_cells_);
    trial.time = std::abs(error.time) / J;
    by_mesh_ = error_by_mesh(*level, error, rung);
    trial.space = std::max(error.sum_of_moduli() / J - trial.time, trusted * by_mesh_.value_or(0));
    level_ = std::move(level);
    rung_ = rung;
    row_ = level_->record();
    if (sizes_vary())
      row_.size = problem.mesh.diameter() / std::pow(problem.mesh.cells(), 1.0 / problem.mesh.dim());
    row_.seconds = trial.seconds = elapsed.seconds();
    return trial;
  }

  /// Compares J with its value for steps of half the length; raises the error in time and sets the warning.
  void verify(TrialRun& trial) override {
    problem::ControlProblem& control_problem = level_->control_problem();
    const Verified found = verify_with_half_steps(level_->problem(), control_problem);
    trial.time = std::max(trial.time, found.change / std::abs(control_problem.reduced.value().total()));
    Measured measured;
    measured.warnings = found.warnings;
    trial.warning = measured.warning({"J", "J", ""});
    if (!by_mesh_ && trial.warning.empty())
      trial.warning = no_coarser_mesh;
  }

  void conclude(const TrialRun& trial, bool better) override {
    if (better)
      write(trial);
    console_.line(fmt::format(
        "round {}: {} unknowns, {} steps: J = {:.6e}, estimated relative error {:.2e} (space {:.1e}, time "
        "{:.1e}, search {:.1e}). {} forward + {} adjoint sweeps, {:.2g} s; {:.2g} s so far{}",
        rows_.size() + 1, row_.free_unknowns, row_.steps, row_.objective, trial.error(), trial.space,
        trial.time, trial.search, row_.forward_sweeps, row_.adjoint_sweeps, row_.seconds, elapsed_.seconds(),
        better ? "" : "; not written, since an earlier round has a smaller error"));
    rows_.push_back(row_);
  }

private:
  /// Writes the results of the last run. Does so even if the time limit has passed, since they are the best.
  void write(const TrialRun& trial) {
    const io::Accuracy accuracy{.quantity = "J",
                                .asked = error_,
                                .space = trial.space,
                                .time = trial.time,
                                .search = trial.search,
                                .met = trial.meets(trusted * error_),
                                .warning = trial.warning};
    log_->store(level_->state());
    folder_->write("indicators.csv", indicators());
    drivers::write_results(
        *folder_, *log_,
        {.stop = level_->stop(), .first_norm = level_->first_norm(), .levels = rows_, .accuracy = accuracy},
        Console(false, false));
  }

  /// Whether error indicators determine the element sizes of each run. If so, a .geo with mesh.size = "auto"
  /// is meshed anew for each run, and a .msh is refined.
  [[nodiscard]] bool sizes_vary() const { return scene_.mesh.automatic() || scene_.mesh.meshed(); }

  /// Text of indicators.csv: the corners of each cell (m), and the cell's share in the error of J in space,
  /// relative to J. Collective.
  [[nodiscard]] std::string indicators() const {
    std::vector<double> shares;
    const mesh::SizeField cells = mesh::gather_cells(level_->problem().mesh, by_cells_, shares);
    const auto dim = static_cast<std::size_t>(cells.dim), corners = dim + 1;
    const double J = std::abs(level_->control_problem().reduced.value().total());
    std::string text;
    for (std::size_t i = 0; i < corners; ++i)
      for (std::size_t c = 0; c < dim; ++c)
        text += fmt::format("{}{},", "xyz"[c], i);
    text += "indicator\n";
    for (std::size_t cell = 0; cell < shares.size(); ++cell) {
      for (std::size_t i = 0; i < corners; ++i)
        for (std::size_t c = 0; c < dim; ++c)
          text += fmt::format(
              "{:.9g},", cells.points[3 * static_cast<std::size_t>(cells.cells[cell * corners + i]) + c]);
      text += fmt::format("{:.3e}\n", shares[cell] / J);
    }
    return text;
  }

  /// Possible relative error of J due to the mesh, at the control found by `level`, whose estimate is
  /// `error`. The mesh that it is compared with has elements twice as large or, if a .msh is refined, is that
  /// of the previous run. Absent if there is no such mesh.
  std::optional<double> error_by_mesh(drivers::SearchLevel<Method>& level, const adjoint::ErrorParts& error,
                                      const Rung& rung) {
    const mesh::Mesh& mesh = level.problem().mesh;
    const control::ControlSpace& controls = level.control_problem().controls;
    const control::ReducedProblem& reduced = level.control_problem().reduced;
    const auto compared = [&](const problem::Problem& problem,
                              problem::ControlProblem& there) -> std::optional<double> {
      constexpr double least = 1.25; // below that, the scatter of neighbouring meshes decides
      const double more = static_cast<double>(mesh.cells()) / static_cast<double>(problem.mesh.cells()),
                   ratio = std::pow(more, 1.0 / mesh.dim()), J = reduced.value().total();
      if (ratio < least)
        return std::nullopt;
      const EstimatedValue coarse = estimated_value(controls, reduced.control(), problem, there);
      return error_by_coarser_mesh({J, error}, coarse, ratio) / std::abs(J);
    };
    if (scene_.mesh.meshed())
      return level_ ? compared(level_->problem(), level_->control_problem()) : std::nullopt;
    constexpr double coarser_by = 2;
    Rung coarser = rung;
    coarser.size *= coarser_by;
    scene::Scene scene = on_rung(scene_, coarser);
    mesh::Meshing meshing;
    std::optional<mesh::SizeField> sizes;
    if (sizes_vary()) {
      scene.mesh = scene_.mesh;
      sizes = mesh::sizes_by(mesh, by_cells_, coarser_by * coarser_by, reach().finer);
      meshing.sizes = &*sizes;
    }
    Timers timers;
    const Console silent(false, false);
    try {
      problem::Problem problem(
          std::make_shared<const problem::SpaceDiscretisation>(comm_, scene, timers, meshing), scene,
          problem::search_needs(scene), timers);
      if (!problem.grid.complete())
        problem::choose_steps(problem, controls, reduced.control(), silent);
      problem::ControlProblem there(problem, silent);
      return compared(problem, there);
    } catch (const UserError&) { // a mesh that coarse cannot be made
    } catch (const SolverFailure&) {
    }
    return std::nullopt;
  }

  /// Searches until the decrease of J over the last iterations, and the predicted decrease, are small
  /// compared with the requested error. Returns the larger of both, relative to J.
  double search(drivers::SearchLevel<Method>& level) {
    optimize::Options options = drivers::search_options(level.control_problem().controls, scene_.optimizer);
    options.max_iterations = std::max(options.max_iterations, most_iterations);
    const auto start = level_ ? level_->start_for(level.control_problem(), options)
                              : drivers::SearchStart<Method>{level.first_guess()};
    /// Records iterates, and ends the search when the decrease of J becomes small.
    struct Report {
      drivers::SearchLog& record;
      double enough, promised = 0;
      bool operator()(const optimize::Iteration& iteration) {
        record(iteration);
        constexpr int fewest = 3;
        promised = iteration.predicted_decrease / std::abs(iteration.objective);
        return iteration.number < fewest || std::max(promised, gained(record.history())) > enough;
      }
      void certified(const optimize::Certificate<control::Variables>& certificate) {
        record.certified(certificate);
      }
    } report{*log_, search_part * trusted * error_};
    level.search(start, options, report);
    return std::isfinite(report.promised) ? std::max(report.promised, gained(log_->history()))
                                          : gained(log_->history());
  }

  /// Decrease of J over the last third of the iterations (at least three), relative to J. If the search
  /// converges linearly, the remaining decrease is smaller. If J approaches its limit like one over the
  /// number of iterations, as among kinks, the remaining decrease is twice as large.
  static double gained(const io::History& history) {
    constexpr std::size_t fewest = 3, part = 3;
    const std::size_t iterations = history.rows() - 1,
                      counted = std::min(iterations, std::max(fewest, iterations / part));
    const double last = history.last("objective");
    return std::max(0.0, history.at(iterations - counted, "objective") - last) / std::abs(last);
  }

  MPI_Comm comm_;
  const scene::Scene& scene_;
  std::filesystem::path out_;
  double error_; ///< requested relative error of J
  const Elapsed& elapsed_;
  const Console& console_;
  // Of the last run:
  Rung rung_;
  scene::Scene written_;
  std::unique_ptr<drivers::SearchLevel<Method>> level_;
  std::optional<double>
      by_mesh_; ///< possible relative error due to the mesh, by comparison with a coarser one
  std::vector<double> by_cells_; ///< error indicators of the cells on this rank
  std::optional<io::OutputFolder> folder_;
  std::optional<drivers::SearchLog> log_;
  io::CoarseLevel row_;
  std::vector<io::CoarseLevel> rows_; ///< records of all runs
};

template <template <optimize::TwiceDifferentiable> class Method>
int refine(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
           const AccuracyAsked& asked, const Console& console) {
  const Elapsed elapsed(comm);
  if (asked.budget)
    stop_after(*asked.budget);
  SearchTrials<Method> trials(comm, scene, out, asked.error, elapsed, console);
  Refinement refinement(trials, trusted * asked.error, asked.budget, elapsed, console);
  return refine_to_accuracy(comm, refinement, trials, asked, out, console);
}

} // namespace

int optimize_to_accuracy(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                         const AccuracyAsked& asked, const Console& console) {
  drivers::require_control_problem(comm, scene, out);
  require_estimable(scene, "--accuracy", "compare sizes and steps by study");
  if (scene.mesh.degree != 1)
    throw UserError(fmt::format("--accuracy: found mesh.degree = {}; set it to 1, since the error estimate "
                                "in space compares degree 1 with degree 2",
                                scene.mesh.degree));
  if (!scene.mesh.meshed() && !scene.mesh.automatic())
    require_size_takes_effect(comm, scene);
  return drivers::with_method(scene.optimizer.method,
                              [&]<template <optimize::TwiceDifferentiable> class Method>() {
                                return refine<Method>(comm, scene, out, asked, console);
                              });
}

} // namespace signorini::accuracy
