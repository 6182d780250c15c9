// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/coarse_start.h"
#include "base/collective.h"
#include "base/error.h"
#include "drivers/search.h"
#include "drivers/search_level.h"
#include "optimize/lbfgs.h"
#include "optimize/newton_cg.h"
#include "optimize/projected_gradient.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

namespace signorini::drivers {
namespace {

/// Multiples of the scene's element size and time step for the coarse levels, in descending order.
constexpr int multiples[] = {4, 2};

/// Least numbers of cells and steps of a coarse level. A smaller level predicts little of the next level,
/// whose search is cheap anyway. A half disc of 200 cells still saves half of the sweeps on 800 cells.
constexpr double least_cells = 100;
constexpr int least_steps = 10;

/// Gradient norm at which the search on a coarse level stops, relative to the norm at the first guess. The
/// remaining error is below that of the discretisation. With ten times this tolerance the next mesh takes
/// twice the sweeps; with a third of it, no fewer (half disc at 0.5 m: 57, 29 and 37 sweeps).
constexpr double coarse_tolerance = 1e-3;
/// Largest number of iterations on a coarse level; a search without inherited state needs about half of it.
constexpr int most_iterations = 60;

/// Scene of a coarse level, without output.
scene::Scene coarser(const scene::Scene& scene, int multiple) {
  scene::Scene coarse =
      scene::resized(scene, *scene.mesh.size * multiple, (scene.time.steps + multiple - 1) / multiple);
  coarse.output.fields.clear();
  coarse.output.tables.clear();
  coarse.output.probes.clear();
  return coarse;
}

/// Whether a coarse level has enough cells and steps, as estimated from the scene's mesh.
bool worth(const problem::Problem& problem, int multiple) {
  const double cells = static_cast<double>(problem.mesh.cells()) / std::pow(multiple, problem.mesh.dim());
  const scene::Time time = coarser(problem.scene, multiple).time;
  return cells >= least_cells && (time.automatic() || time.steps >= least_steps);
}

/// Throws UserError if a coarse mesh has more than half of the cells of the fine mesh, as with a .geo that
/// sets sizes itself.
void require_fewer_cells(const problem::Problem& coarse, const problem::Problem& fine) {
  if (2 * coarse.mesh.cells() > fine.mesh.cells())
    throw UserError(fmt::format("it has {} cells, more than half of the {} cells of the scene's mesh",
                                coarse.mesh.cells(), fine.mesh.cells()));
}

std::string words(const io::CoarseLevel& level) {
  return fmt::format("coarse mesh of size {:.4g} m, {} free unknowns, {} steps of {:.4g} s. {} iterations, "
                     "{} forward + {} adjoint sweeps in {:.1f} s, J = {:.6e}: {}",
                     level.size, level.free_unknowns, level.steps, level.step, level.iterations,
                     level.forward_sweeps, level.adjoint_sweeps, level.seconds, level.objective,
                     level.stop_reason);
}

} // namespace

std::vector<int> coarse_multiples(const problem::Problem& problem) {
  const scene::Optimizer& search = problem.scene.optimizer;
  std::vector<int> worthwhile;
  if (problem.scene.objective && search.start == scene::SearchStart::coarse && search.max_iterations > 0)
    std::ranges::copy_if(multiples, std::back_inserter(worthwhile),
                         [&](int multiple) { return worth(problem, multiple); });
  return worthwhile;
}

template <template <optimize::TwiceDifferentiable> class Method>
SearchStart<Method> search_start(const problem::Problem& problem, problem::ControlProblem& control_problem,
                                 const optimize::Options& options, const Console& console,
                                 std::vector<io::CoarseLevel>& levels) {
  const scene::Scene& scene = problem.scene;
  const std::vector<int> levels_worth = coarse_multiples(problem);
  std::unique_ptr<SearchLevel<Method>> last;
  if (!levels_worth.empty()) {
    const auto timer = problem.timers.time("coarse meshes");
    const auto left_out = [&](const scene::Scene& coarse, const std::exception& error) {
      console.line(
          fmt::format("the coarse mesh of size {:.4g} m is left out: {}", *coarse.mesh.size, error.what()));
    };
    for (const int multiple : levels_worth) {
      const scene::Scene coarse = coarser(scene, multiple);
      const Elapsed elapsed(problem.space.comm());
      try {
        auto level =
            std::make_unique<SearchLevel<Method>>(problem.space.comm(), coarse, mesh::Meshing{}, last.get());
        require_fewer_cells(level->problem(), problem);
        optimize::Options loose = search_options(level->control_problem().controls, scene.optimizer);
        loose.max_iterations = most_iterations; // whatever the scene's, which may change on --resume
        loose.tolerance = std::max(loose.tolerance, coarse_tolerance);
        loose.through_kinks = false;
        level->search(last ? last->start_for(level->control_problem(), loose)
                           : SearchStart<Method>{level->first_guess()},
                      loose, [](const optimize::Iteration&) {});
        io::CoarseLevel record = level->record();
        last = std::move(level);
        record.seconds = elapsed.seconds();
        console.line(words(record));
        levels.push_back(std::move(record));
      } catch (const UserError& error) {
        left_out(coarse, error);
      } catch (const SolverFailure& error) {
        left_out(coarse, error);
      }
    }
    if (last)
      return last->start_for(control_problem, options);
  }
  return {control_problem.first_guess(scene)};
}

template SearchStart<optimize::Lbfgs> search_start(const problem::Problem&, problem::ControlProblem&,
                                                   const optimize::Options&, const Console&,
                                                   std::vector<io::CoarseLevel>&);
template SearchStart<optimize::NewtonCg> search_start(const problem::Problem&, problem::ControlProblem&,
                                                      const optimize::Options&, const Console&,
                                                      std::vector<io::CoarseLevel>&);
template SearchStart<optimize::ProjectedGradient> search_start(const problem::Problem&,
                                                               problem::ControlProblem&,
                                                               const optimize::Options&, const Console&,
                                                               std::vector<io::CoarseLevel>&);

} // namespace signorini::drivers
