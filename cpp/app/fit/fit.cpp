// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/fit/fit.h"
#include "app/fit/outcome.h"
#include "app/fit/simulated.h"
#include "app/motion_writer.h"
#include "app/run_manifest.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/signals.h"
#include "scene/time_series.h"
#include <charconv>
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
/// the end. From its last row a search goes on.
class History {
public:
  History(const scene::Scene& scene, const io::OutputFolder& folder)
      : scene_(scene), folder_(folder),
        text_("iteration,objective,decrement,damping,forward_sweeps,seconds") {
    for (const scene::Unknown& unknown : scene.unknowns)
      text_ += "," + unknown.name;
    text_ += '\n';
  }

  struct Row {
    int number = 0, sweeps = 0;
    double objective = 0, decrement = 0, damping = 0, seconds = 0;
    std::vector<double> values;
  };

  void add(const Row& row) {
    text_ += fmt::format("{},{:.17g},{:.17g},{:.17g},{},{:.3f},{:.17g}\n", row.number, row.objective,
                         row.decrement, row.damping, row.sweeps, row.seconds, fmt::join(row.values, ","));
    if (rank(folder_.comm()) != 0)
      return;
    const std::filesystem::path part = folder_.staged("history.csv.part");
    std::ofstream(part, std::ios::binary) << text_ << std::flush;
    std::error_code ignored; // the whole table is written again, and checked, at the end
    std::filesystem::rename(part, folder_.path() / file, ignored);
  }

  /// The last row of the folder's table, which is taken over; none where there is no table. Collective.
  /// Throws UserError if it is of another fit.
  std::optional<Row> restore() {
    std::string text;
    int found = 0;
    on_root(folder_.comm(), [&] {
      found = std::filesystem::exists(folder_.path() / file);
      if (found)
        text = scene::read_file(folder_.path() / file);
    });
    MPI_Bcast(&found, 1, MPI_INT, 0, folder_.comm());
    if (!found)
      return std::nullopt;
    text = broadcast(folder_.comm(), text);
    text.erase(text.rfind('\n') + 1); // of a row that was being written
    const std::string head = text.substr(0, text.find('\n') + 1);
    std::vector<double> numbers;
    for (std::string_view line = last_line(text); !line.empty(); line.remove_prefix(1)) {
      double number = 0;
      const auto end = std::from_chars(line.data(), line.data() + line.size(), number).ptr;
      numbers.push_back(number);
      line.remove_prefix(static_cast<std::size_t>(end - line.data()));
      if (line.empty())
        break;
    }
    constexpr std::size_t columns = 6;
    if (head != text_ || numbers.size() != columns + scene_.unknowns.size())
      throw UserError(
          fmt::format("--resume: {}: found the history of another search, allowed is that of a fit "
                      "of the same unknowns",
                      (folder_.path() / file).string()));
    text_ = text;
    return Row{.number = static_cast<int>(numbers[0]),
               .sweeps = static_cast<int>(numbers[4]),
               .objective = numbers[1],
               .decrement = numbers[2],
               .damping = numbers[3],
               .seconds = numbers[5],
               .values = {numbers.begin() + columns, numbers.end()}};
  }

  [[nodiscard]] const std::string& text() const { return text_; }

  static constexpr const char* file = "history.csv";

private:
  static std::string_view last_line(std::string_view text) {
    text.remove_suffix(text.empty() ? 0 : 1);
    return text.substr(text.rfind('\n') + 1);
  }

  const scene::Scene& scene_;
  const io::OutputFolder& folder_;
  std::string text_;
};

/// The search, from the start or where another stopped. Throws UserError, SolverFailure, Interrupted.
class Search {
public:
  Search(FitProblem& problem, const io::OutputFolder& folder, const Console& console)
      : problem_(problem), folder_(folder), console_(console), history_(problem.scene(), folder) {}

  optimize::GaussNewtonResult run(bool resume) {
    optimize::GaussNewtonIterate start = first(resume);
    const scene::Optimizer& options = problem_.scene().optimizer;
    const MPI_Comm comm = folder_.comm();
    const auto agree = [comm](std::span<double> numbers) {
      MPI_Bcast(numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, 0, comm);
    };
    try {
      return optimize::gauss_newton(
          [&](std::span<const double> x) { return attempt(x); }, std::move(start), problem_.box(),
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
    const std::optional<History::Row> row = resume ? history_.restore() : std::nullopt;
    if (resume && !row)
      console_.line(
          fmt::format("no {} in {}: starting from the first guess", History::file, folder_.path().string()));
    optimize::GaussNewtonIterate start{.x = row ? problem_.on_scales(row->values) : problem_.start(),
                                       .at = {}};
    start.at = problem_.evaluate(start.x);
    if (!row)
      return start;
    constexpr double other_ranks = 1e-6;
    // Of data without noise J itself is rounding.
    const double size = std::max(row->objective, static_cast<double>(problem_.count()));
    if (!(std::abs(start.at.value() - row->objective) <= other_ranks * size))
      throw UserError(
          fmt::format("--resume: {}: found J = {:.10g} where it was {:.10g}, allowed are the scene, "
                      "mesh and data of the run that was interrupted",
                      (folder_.path() / History::file).string(), start.at.value(), row->objective));
    start.number = row->number;
    start.damping = row->damping;
    earlier_ = row->seconds;
    problem_.count_from(row->sweeps);
    restored_ = true;
    console_.line(fmt::format("resumed after iteration {}", row->number));
    return start;
  }

  /// A trial; none where the scene is none at these values, or a solver fails.
  std::optional<optimize::LeastSquares> attempt(std::span<const double> x) {
    try {
      return problem_.evaluate(x);
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
      const std::vector<double> theta = problem_.values(now.x);
      history_.add({.number = now.number,
                    .sweeps = problem_.sweeps(),
                    .objective = now.at.value(),
                    .decrement = now.decrement,
                    .damping = now.damping,
                    .seconds = seconds(),
                    .values = theta});
      console_.line(fmt::format("{:4d}  J = {:.6e}, decrement {:.2e}; {:.6g}", now.number, now.at.value(),
                                now.decrement, fmt::join(theta, ", ")));
    }
    return !stop_requested(folder_.comm());
  }

  FitProblem& problem_;
  const io::OutputFolder& folder_;
  const Console& console_;
  History history_;
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
  io::OutputFolder folder(comm, out, resume ? History::file : "");
  Timers timers;
  FitProblem fit(std::make_shared<const Discretisation>(comm, scene, timers), scene, timers);
  console.line(fmt::format("fit of {} unknown{} to {} values of {} measurement{}", scene.unknowns.size(),
                           scene.unknowns.size() == 1 ? "" : "s", fit.count(), scene.measurements.size(),
                           scene.measurements.size() == 1 ? "" : "s"));
  print_doubts(fit.doubts(), console);
  Search search(fit, folder, console);
  const optimize::GaussNewtonResult end = search.run(resume);

  const scene::Scene fitted = fit.scene_at(end.last.x);
  const Problem problem(fit.discretisation(), fitted, fit.needs(), timers, forward::Stops::ignored);
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
  add_doubts(m, fit.doubts());
  add_watched(m, recorder, scene.run, console);
  m.iterations = end.last.number;
  m.forward_sweeps = fit.sweeps();
  m.adjoint_sweeps = 0;
  m.fit = std::move(result);
  m.files = folder.files();
  folder.write("run.json", io::to_json(m, scene, timers));
  console.line(fmt::format("J {:.6e}: {} iterations, {} forward sweeps in {:.1f} s", end.last.at.value(),
                           end.last.number, fit.sweeps(), search.seconds()));
  finish(folder, console);
  return end.stop == optimize::Stop::solver_failed ? exit_status::solver_failed
         : end.stop == optimize::Stop::interrupted ? exit_status::interrupted
                                                   : exit_status::done;
}

} // namespace signorini
