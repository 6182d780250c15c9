// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/fit/fit.h"
#include "app/fit/outcome.h"
#include "app/fit/simulated.h"
#include "app/motion_writer.h"
#include "app/resume.h"
#include "app/run_manifest.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/signals.h"
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <limits>
#include <utility>

namespace signorini {
namespace {

using Clock = std::chrono::steady_clock;

/// history.csv of a fit, a row for each iterate, in place as soon as it is made, whether or not it stays at
/// the end.
class History {
public:
  History(const scene::Scene& scene, const io::OutputFolder& folder)
      : folder_(folder), text_("iteration,objective,decrement,damping,forward_sweeps,seconds") {
    for (const scene::Unknown& unknown : scene.unknowns)
      text_ += "," + unknown.name;
    text_ += '\n';
  }

  void add(const optimize::GaussNewtonIterate& now, int sweeps, double seconds,
           const std::vector<double>& values) {
    text_ += fmt::format("{},{:.17g},{:.17g},{:.17g},{},{:.3f},{:.17g}\n", now.number, now.at.value(),
                         now.decrement, now.damping, sweeps, seconds, fmt::join(values, ","));
    show();
  }

  /// Takes over the text of an interrupted search.
  void restore(std::string text) {
    text_ = std::move(text);
    show();
  }

  [[nodiscard]] const std::string& text() const { return text_; }

private:
  void show() const {
    if (rank(folder_.comm()) != 0)
      return;
    const std::filesystem::path part = folder_.staged("history.csv.part");
    std::ofstream(part, std::ios::binary) << text_ << std::flush;
    std::error_code ignored; // the whole table is written again, and checked, at the end
    std::filesystem::rename(part, folder_.path() / "history.csv", ignored);
  }

  const io::OutputFolder& folder_;
  std::string text_;
};

/// The search, from the start or where another stopped. Throws UserError, SolverFailure, Interrupted.
class Search {
public:
  Search(ParameterProblem& problem, const io::OutputFolder& folder, const Console& console)
      : problem_(problem), folder_(folder), console_(console), history_(problem.scene, folder),
        checkpoint_(folder.path() / resume::checkpoint) {}

  optimize::GaussNewtonResult run(bool resume) {
    optimize::GaussNewtonIterate start = first(resume);
    const scene::Optimizer& options = problem_.scene.optimizer;
    const MPI_Comm comm = folder_.comm();
    const auto agree = [comm](std::span<double> numbers) {
      MPI_Bcast(numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, 0, comm);
    };
    try {
      return optimize::gauss_newton(
          [&](std::span<const double> x) { return attempt(x); }, std::move(start), problem_.misfit.box(),
          {.max_iterations = options.max_iterations, .tolerance = options.tolerance, .agree = agree},
          [&](const optimize::GaussNewtonIterate& now) { return take(now); });
    } catch (const Interrupted&) {
      if (!last_)
        throw;
      return {optimize::Stop::interrupted, *std::move(last_)};
    }
  }

  /// Why the last trial that failed did; empty if none has.
  [[nodiscard]] const std::string& failure() const { return failure_; }

  [[nodiscard]] const std::string& history() const { return history_.text(); }
  [[nodiscard]] double seconds() const {
    return earlier_ + std::chrono::duration<double>(Clock::now() - start_).count();
  }

private:
  optimize::GaussNewtonIterate first(bool resume) {
    optimize::GaussNewtonIterate start{.x = problem_.misfit.start(), .at = {}};
    if (!resume || !resume::found(folder_, console_)) {
      start.at = problem_.reduced.least_squares(control::Variables(start.x));
      return start;
    }
    io::CheckpointReader in(folder_.comm(), checkpoint_);
    resume::require_same_problem(in, echoed(), problem_.discretisation->mesh);
    std::string history;
    double objective = 0;
    int sweeps = 0;
    in("history", history);
    in("x", start.x);
    in("objective", objective);
    in("iteration", start.number);
    in("damping", start.damping);
    in("sweeps", sweeps);
    in("seconds", earlier_);
    if (start.x.size() != problem_.scene.unknowns.size())
      in.fail("\"x\" is damaged; allowed is a whole checkpoint");
    start.at = problem_.reduced.least_squares(control::Variables(start.x));
    // Of data without noise J itself is rounding.
    resume::require_same_value(checkpoint_, objective, start.at.value(),
                               std::max(objective, static_cast<double>(problem_.misfit.count())));
    history_.restore(std::move(history));
    problem_.reduced.count_from({.forward = sweeps});
    restored_ = true;
    console_.line(fmt::format("resumed after iteration {}", start.number));
    return start;
  }

  /// Writes a checkpoint. A failure is reported and the search goes on.
  void store(const optimize::GaussNewtonIterate& now) const {
    io::CheckpointWriter out(folder_.comm(), folder_.staged(resume::checkpoint), checkpoint_);
    resume::store_problem(out, echoed(), problem_.discretisation->mesh);
    out("history", history_.text());
    out("x", now.x);
    out("objective", now.at.value());
    out("iteration", now.number);
    out("damping", now.damping);
    out("sweeps", problem_.reduced.sweeps().forward);
    out("seconds", seconds());
    if (const std::string failure = out.commit(); !failure.empty())
      console_.line(resume::not_written(checkpoint_, failure));
  }

  [[nodiscard]] std::string echoed() const {
    return scene::echo(problem_.scene, problem_.discretisation->space.dim());
  }

  /// A trial; none where the scene is none at these values, or a solver fails.
  std::optional<optimize::LeastSquares> attempt(std::span<const double> x) {
    try {
      return problem_.reduced.least_squares(control::Variables(std::vector(x.begin(), x.end())));
    } catch (const UserError& error) {
      failure_ = error.what();
    } catch (const SolverFailure& error) {
      failure_ = error.what();
    }
    return std::nullopt;
  }

  bool take(const optimize::GaussNewtonIterate& now) {
    last_ = now;
    if (!std::exchange(restored_, false)) {
      const std::vector<double> theta = problem_.misfit.values(now.x);
      history_.add(now, problem_.reduced.sweeps().forward, seconds(), theta);
      store(now);
      console_.line(fmt::format("{:4d}  J = {:.6e}, decrement {:.2e}; {:.6g}", now.number, now.at.value(),
                                now.decrement, fmt::join(theta, ", ")));
    }
    return !stop_requested(folder_.comm());
  }

  ParameterProblem& problem_;
  const io::OutputFolder& folder_;
  const Console& console_;
  History history_;
  std::filesystem::path checkpoint_;
  Clock::time_point start_ = Clock::now();
  double earlier_ = 0;
  bool restored_ = false;
  std::optional<optimize::GaussNewtonIterate> last_;
  std::string failure_;
};

std::string stop_words(optimize::Stop stop) {
  return stop == optimize::Stop::gradient_tolerance ? "decrement below tolerance" : optimize::name(stop);
}

} // namespace

int fit_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
              const Console& console) {
  io::OutputFolder folder(comm, out, resume ? resume::checkpoint : "");
  Timers timers;
  ParameterProblem fit(std::make_shared<const Discretisation>(comm, scene, timers), scene, timers);
  console.line(fmt::format("fit of {} unknown{} to {} values of {} measurement{}", scene.unknowns.size(),
                           scene.unknowns.size() == 1 ? "" : "s", fit.misfit.count(),
                           scene.measurements.size(), scene.measurements.size() == 1 ? "" : "s"));
  print_doubts(fit.misfit.doubts(), console);
  Search search(fit, folder, console);
  const optimize::GaussNewtonResult end = search.run(resume);

  const scene::Scene fitted = fit.scene_at(end.last.x);
  const Problem problem(fit.discretisation, fitted, fit.needs(), timers, forward::Stops::ignored);
  MotionWriter recorder(problem, folder, nullptr, true);
  const GivenControl given(problem);
  Simulated simulated = simulate_measured(problem, fit, given.load(), recorder);
  io::Fit result = outcome(fit, end.last, simulated.values);
  result.compared = std::move(simulated.compared);
  if (scene.output.table(scene::StoredTable::history))
    folder.write("history.csv", search.history());
  if (scene.output.table(scene::StoredTable::parameters))
    folder.write("parameters.csv", io::parameters_table(result));
  if (scene.output.table(scene::StoredTable::measurements))
    folder.write("measurements.csv", io::measurements_table(result));
  folder.write("scene.toml", scene::echo(scene, problem.space.dim()));
  console.line("stopped: " + stop_words(end.stop));
  if (end.stop == optimize::Stop::solver_failed || end.stop == optimize::Stop::no_decrease)
    if (!search.failure().empty())
      console.line("the last trial that failed: " + search.failure());
  for (const std::string& line : outcome_lines(result))
    console.line(line);
  io::Manifest m = manifest(problem, "optimize", stop_words(end.stop), problem.steps());
  add_doubts(m, fit.misfit.doubts());
  add_watched(m, recorder, scene.run, console);
  add_warning(m, misfit_warning(result), console);
  m.iterations = end.last.number;
  m.forward_sweeps = fit.reduced.sweeps().forward;
  m.adjoint_sweeps = 0;
  m.fit = std::move(result);
  m.files = folder.files();
  folder.write("run.json", io::to_json(m, scene, timers));
  console.line(fmt::format("J {:.6e}: {} iterations, {} forward sweeps in {:.1f} s", end.last.at.value(),
                           end.last.number, fit.reduced.sweeps().forward, search.seconds()));
  finish(folder, console);
  return end.stop == optimize::Stop::solver_failed ? exit_status::solver_failed
         : end.stop == optimize::Stop::interrupted ? exit_status::interrupted
                                                   : exit_status::done;
}

} // namespace signorini
