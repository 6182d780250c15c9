// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/optimize_to_accuracy.h"
#include "accuracy/error_estimate.h"
#include "accuracy/grading.h"
#include "accuracy/quantities.h"
#include "accuracy/refinement.h"
#include "base/signals.h"
#include "drivers/run_manifest.h"
#include "drivers/search.h"
#include "drivers/search_level.h"
#include "drivers/search_results.h"
#include "mesh/size_field.h"
#include "optimize/lbfgs.h"
#include "optimize/newton_cg.h"
#include "optimize/projected_gradient.h"
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>

namespace signorini::accuracy {
namespace {

using Clock = std::chrono::steady_clock;

/// Of the error asked for, so that the estimate may be half of it (docs/method.md section 7) and the
/// next round meets it though it falls a little less than foreseen.
constexpr double trusted = 0.5, aimed = 0.4;
/// Of that, what the search may leave.
constexpr double search_part = 0.05;
/// Of a search, where the scene allows fewer: it ends by what it gains.
constexpr int most_iterations = 1000;
/// Least factor of size and step from round to round: the estimate of a coarse mesh tells little of one much
/// finer.
constexpr double trusted_reach = 1.0 / 3;
/// Multiples of the scene's size and step to begin with, the first that can be.
constexpr std::array beginnings{4.0, 2.0, 1.0};
constexpr int least_steps = 10;
/// Each is to leave less than half of the error.
constexpr std::size_t most_rounds = 20;
/// Rounds whose estimate is small enough but that have a warning.
constexpr int most_warned = 3;

/// Sizes and steps of a round.
struct Resolution {
  double size = 1; ///< of the scene's, or of the first mesh's where sizes vary
  double step = 1; ///< of the scene's; of steps of varying length, the square root of the tolerance's
  std::optional<mesh::SizeField> sizes{}; ///< on rank 0, where they vary
};

scene::Scene at(const scene::Scene& scene, const Resolution& resolution) {
  scene::Scene made = scene;
  if (!scene.mesh.automatic() && !scene.mesh.meshed())
    (made.mesh.size ? *made.mesh.size : made.mesh.scale) *= resolution.size;
  if (scene.time.automatic()) {
    made.time.tolerance =
        std::min(scene::Time::most_tolerance, scene.time.tolerance * resolution.step * resolution.step);
    return made;
  }
  made.time.steps = std::max(least_steps, static_cast<int>(std::ceil(scene.time.steps / resolution.step)));
  made.time.step = made.time.end / made.time.steps;
  return made;
}

/// Parts of the error, relative.
struct Parts {
  double space = 0, time = 0, search = 0;
  [[nodiscard]] double sum() const { return space + time + search; }
};

constexpr double least_order = 0.7; ///< of fronts of an impact

template <template <optimize::TwiceDifferentiable> class Method>
class Rounds {
public:
  Rounds(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
         const AccuracyAsked& asked, const Console& console)
      : comm_(comm), scene_(scene), out_(out), asked_(asked), console_(console) {}

  int run() {
    if (asked_.budget)
      stop_after(*asked_.budget);
    try {
      begin();
      while (!met()) {
        const std::optional<Resolution> next = finer();
        if (!next)
          break;
        round(*next);
      }
    } catch (const Interrupted&) {
      if (records_.empty())
        throw;
      interrupted_ = true;
    } catch (const UserError&) { // on all ranks, like the next
      conclude_failed();
      throw;
    } catch (const SolverFailure&) {
      conclude_failed();
      throw;
    }
    const bool late = time_is_up(comm_);
    forget_deadline();
    console_.line(sentence(late));
    return met()                   ? exit_status::done
           : interrupted_ && !late ? exit_status::interrupted
                                   : exit_status::check_failed;
  }

private:
  /// Says what is there before the reason of a round's failure is written.
  void conclude_failed() {
    forget_deadline();
    if (records_.empty())
      return;
    ended_ = "the next round failed";
    console_.line(sentence(false));
  }

  /// Those of the elements, from round to round by indicators: with mesh.size = "auto" the .geo is meshed
  /// again by them, and a .msh is refined.
  [[nodiscard]] bool sizes_vary() const { return scene_.mesh.automatic() || scene_.mesh.meshed(); }

  [[nodiscard]] bool enough(const Parts& parts) const { return parts.sum() <= trusted * asked_.error; }
  [[nodiscard]] bool met() const { return !records_.empty() && enough(parts_) && warning_.empty(); }
  [[nodiscard]] double passed() const {
    double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    MPI_Bcast(&seconds, 1, MPI_DOUBLE, 0, comm_);
    return seconds;
  }

  void begin() {
    for (const double multiple : beginnings) {
      const bool last = multiple == beginnings.back();
      try {
        return round({.size = multiple, .step = multiple});
      } catch (const UserError&) { // a mesh that coarse cannot be made
        if (last)
          throw;
      } catch (const SolverFailure&) {
        if (last)
          throw;
      }
    }
  }

  void round(const Resolution& resolution) {
    const auto start = Clock::now();
    io::OutputFolder folder(comm_, out_, drivers::resume::checkpoint);
    scene::Scene written = at(scene_, resolution);
    mesh::Meshing meshing;
    if (sizes_vary()) {
      meshing.sizes = resolution.sizes ? &*resolution.sizes : nullptr;
      meshing.keep = folder.staged("mesh.msh");
      written.mesh.file = folder.path() / "mesh.msh";
      written.mesh.size.reset();
    }
    auto level = std::make_unique<drivers::SearchLevel<Method>>(comm_, at(scene_, resolution), meshing,
                                                                last_.get(), problem::search_needs(scene_));
    const problem::Problem& problem = level->problem();
    problem::ControlProblem& control_problem = level->control_problem();
    const drivers::SearchSubject subject{
        written,  *problem.discretisation, control_problem.reduced, problem.timers,
        &problem, &control_problem};
    drivers::SearchLog record(subject, folder, false, console_, drivers::SearchLog::Files::with_results);
    Parts parts;
    parts.search = search(*level, record);
    record.end();
    const double J = std::abs(control_problem.reduced.value().total());
    if (!(J > 0))
      throw UserError(
          "--accuracy: found an optimum with J = 0, allowed is one whose error can be relative to J");
    std::vector<double> by_cells;
    const adjoint::ErrorParts error = estimate_error(problem, control_problem, &by_cells);
    parts.time = std::abs(error.time) / J;
    parts.space = error.sum_of_moduli() / J - parts.time;
    warning_.clear();
    if (enough(parts))
      verify(problem, control_problem, parts);
    // No fewer steps than the least, whatever the multiple.
    const double step = scene_.time.automatic()
                            ? resolution.step
                            : static_cast<double>(scene_.time.steps) / static_cast<double>(problem.steps());
    orders_ = {observed_order(parts_.space, parts.space, resolution.size / resolution_.size, orders_.size,
                              least_order),
               observed_order(parts_.time, parts.time, step / resolution_.step, orders_.step, least_order)};
    parts_ = parts;
    resolution_.size = resolution.size, resolution_.step = step;
    by_cells_ = std::move(by_cells);
    last_ = std::move(level);
    io::CoarseLevel row = last_->record();
    if (sizes_vary())
      row.size = problem.mesh.diameter() / std::pow(problem.mesh.cells(), 1.0 / problem.mesh.dim());
    row.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    // Written even if the time is up by now: there is an answer, and it is the best so far.
    const io::Accuracy accuracy{.quantity = "J",
                                .asked = asked_.error,
                                .space = parts.space,
                                .time = parts.time,
                                .search = parts.search,
                                .met = enough(parts) && warning_.empty(),
                                .warning = warning_};
    record.store(last_->state());
    folder.write("indicators.csv", indicators());
    drivers::write_results(
        folder, subject, record,
        {.stop = last_->stop(), .first_norm = last_->first_norm(), .levels = records_, .accuracy = accuracy},
        Console(false, false));
    console_.line(fmt::format(
        "round {}: {} unknowns, {} steps: J = {:.6e}, estimated error {:.2e} (space {:.1e}, "
        "time {:.1e}, search {:.1e}), {} + {} sweeps, {:.2g} s; {:.2g} s so far",
        records_.size() + 1, row.free_unknowns, row.steps, row.objective, parts.sum(), parts.space,
        parts.time, parts.search, row.forward_sweeps, row.adjoint_sweeps, row.seconds, passed()));
    records_.push_back(std::move(row));
  }

  /// Compares J with that of half the steps, which may say more of them than the estimate, and looks for what
  /// they may have missed.
  void verify(const problem::Problem& problem, const problem::ControlProblem& control_problem, Parts& parts) {
    const Verified found = verify_with_half_steps(problem, control_problem);
    parts.time = std::max(parts.time, found.change / std::abs(control_problem.reduced.value().total()));
    const Quantity J{"J", "J", ""};
    warning_ = Measured{.warnings = found.warnings}.warning(J);
  }

  /// indicators.csv: the corners of each cell (m) and its share in the error of J in space, relative.
  /// Collective.
  [[nodiscard]] std::string indicators() const {
    std::vector<double> shares;
    const mesh::SizeField cells = mesh::gathered(last_->problem().mesh, by_cells_, shares);
    const auto dim = static_cast<std::size_t>(cells.dim), corners = dim + 1;
    const double J = std::abs(last_->control_problem().reduced.value().total());
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

  /// Searches until what the last iterations have gained is a small part of the error asked for; returns it,
  /// relative.
  double search(drivers::SearchLevel<Method>& level, drivers::SearchLog& record) {
    optimize::Options options = drivers::search_options(level.control_problem().controls, scene_.optimizer);
    options.max_iterations = std::max(options.max_iterations, most_iterations);
    const auto start = last_ ? last_->on(level.control_problem(), options)
                             : drivers::SearchStart<Method>{level.first_guess()};
    /// Tells the record, and ends the search.
    struct Report {
      drivers::SearchLog& record;
      double enough, promised = 0;
      bool operator()(const optimize::Iteration& iteration) {
        record(iteration);
        constexpr int fewest = 3;
        promised = iteration.promised / std::abs(iteration.objective);
        return iteration.number < fewest || std::max(promised, gained(record.history())) > enough;
      }
      void certified(const optimize::Certificate<control::Variables>& certificate) {
        record.certified(certificate);
      }
    } report{record, search_part * trusted * asked_.error};
    level.search(start, options, report);
    return std::isfinite(report.promised) ? std::max(report.promised, gained(record.history()))
                                          : gained(record.history());
  }

  /// What the last third of the iterations has gained of J, relative: more than what is left where a search
  /// converges linearly, half of it where its gains fall as the number of iterations, as among kinks.
  static double gained(const io::History& history) {
    constexpr std::size_t fewest = 3, part = 3;
    const std::size_t iterations = history.rows() - 1,
                      counted = std::min(iterations, std::max(fewest, iterations / part));
    const double last = history.last("objective");
    return std::max(0.0, history.at(iterations - counted, "objective") - last) / std::abs(last);
  }

  /// The next round: the cheapest size and step for which both parts add up to what is aimed at; absent if
  /// nothing can be refined, or the budget does not reach.
  [[nodiscard]] std::optional<Resolution> finer() {
    if (records_.size() == most_rounds) {
      ended_ = fmt::format("its estimate does not fall in {} rounds", most_rounds);
      return std::nullopt;
    }
    if (!warning_.empty() && ++warned_ == most_warned) {
      ended_ = warning_;
      return std::nullopt;
    }
    Resolution next = aimed_at(aimed * asked_.error);
    if (asked_.budget && !fits(next)) {
      ended_ = fmt::format("a next round is beyond the budget of {:.3g} s", *asked_.budget);
      return std::nullopt;
    }
    if (sizes_vary()) {
      const double part = next.size / resolution_.size;
      next.sizes = mesh::sizes_by(last_->problem().mesh, by_cells_, part * part, 1 / trusted_reach);
    }
    return next;
  }

  /// Makes a round coarser where it would not end within the budget; false if little is left to refine then.
  [[nodiscard]] bool fits(Resolution& next) const {
    constexpr double safe = 0.7, worth = 1.5; // of the time left; times the cost of the last round
    const double left = safe * (*asked_.budget - passed()), expected = cost(next),
                 last = records_.back().seconds;
    if (expected <= left)
      return true;
    if (left < worth * last)
      return false;
    const double part = std::log(left / last) / std::log(expected / last);
    next.size = resolution_.size * std::pow(next.size / resolution_.size, part);
    next.step = resolution_.step * std::pow(next.step / resolution_.step, part);
    return true;
  }

  /// `reach`: the least factor of size and step.
  [[nodiscard]] Resolution aimed_at(double error, double reach = trusted_reach) const {
    const SizeAndStep factors =
        cheapest_factors({parts_.space, parts_.time}, orders_, error, last_->problem().mesh.dim(), reach, 1);
    constexpr double worth = 0.95; // the largest factor that is worth a change
    Resolution next{.size = resolution_.size * (factors.size < worth ? factors.size : 1),
                    .step = resolution_.step * (factors.step < worth ? factors.step : 1)};
    if (next.size == resolution_.size && next.step == resolution_.step) {
      constexpr double little = 0.8;
      (parts_.space > parts_.time ? next.size : next.step) *= little;
    }
    return next;
  }

  /// Seconds of a round, by those of the last.
  [[nodiscard]] double cost(const Resolution& next) const {
    const int dim = last_->problem().mesh.dim();
    return records_.back().seconds * std::pow(resolution_.size / next.size, dim * step_power(dim)) *
           resolution_.step / next.step;
  }

  [[nodiscard]] std::string sentence(bool late) const {
    const io::CoarseLevel& last = records_.back();
    std::string text = fmt::format("{:g} of J asked, {:.2e} estimated (space {:.1e}, time {:.1e}, search "
                                   "{:.1e}): {}; {} unknowns and {} "
                                   "steps, {:.2g} s in {} rounds, of which the last took {:.2g} s; {} "
                                   "would take about {:.2g} s",
                                   asked_.error, parts_.sum(), parts_.space, parts_.time, parts_.search,
                                   met()              ? std::string("met")
                                   : late             ? "not met, the budget is spent"
                                   : interrupted_     ? "not met, interrupted"
                                   : warning_.empty() ? "not met, " + ended_
                                                      : "not verified, " + warning_,
                                   last.free_unknowns, last.steps, passed(), records_.size(), last.seconds,
                                   enough(parts_) ? "half the error" : "what is asked",
                                   enough(parts_) ? cost(aimed_at(parts_.sum() / 2))
                                                  : cost(aimed_at(aimed * asked_.error, 0)));
    return text + fmt::format("\nresults in {}", out_.string());
  }

  MPI_Comm comm_;
  const scene::Scene& scene_;
  std::filesystem::path out_;
  AccuracyAsked asked_;
  const Console& console_;
  Clock::time_point start_ = Clock::now();
  std::unique_ptr<drivers::SearchLevel<Method>> last_;
  Resolution resolution_; ///< of the last round, without sizes
  Parts parts_;
  std::vector<double> by_cells_; ///< indicators of its mesh
  SizeAndStep orders_{2, 2};
  std::vector<io::CoarseLevel> records_;
  std::string ended_, warning_; ///< why there is no further round; why the last is not verified
  int warned_ = 0;              ///< rounds
  bool interrupted_ = false;
};

} // namespace

int optimize_to_accuracy(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                         const AccuracyAsked& asked, const Console& console) {
  drivers::require_control_problem(comm, scene, out);
  if (scene.mesh.degree != 1)
    throw UserError(fmt::format("--accuracy: found mesh.degree = {}, allowed is 1: the estimate in space "
                                "looks at what functions of degree 2 have beyond those of degree 1",
                                scene.mesh.degree));
  if (!scene.mesh.meshed() && !scene.mesh.automatic())
    require_answer(comm, scene);
  switch (scene.optimizer.method) {
  case scene::OptimizerMethod::lbfgs:
    return Rounds<optimize::Lbfgs>(comm, scene, out, asked, console).run();
  case scene::OptimizerMethod::newton_cg:
    return Rounds<optimize::NewtonCg>(comm, scene, out, asked, console).run();
  case scene::OptimizerMethod::projected_gradient:
  case scene::OptimizerMethod::gauss_newton: // of fits alone
    break;
  }
  return Rounds<optimize::ProjectedGradient>(comm, scene, out, asked, console).run();
}

} // namespace signorini::accuracy
