// SPDX-License-Identifier: GPL-3.0-or-later
// Seconds of a scene's steps in units of the floor that no step can go below: one solve with D and the
// products with M and R, timed between the steps of the same run, on the same matrices, in the same state of
// caches and machine.
//
// usage: signorini-bench SCENE REPEATS [key.path=value …]    prints one JSON object
#include "bench.h"
#include "../recorded.h"

using namespace signorini;
using petsc::check;

namespace {

/// The least of each step's times over the repeats: what the step takes when nothing disturbs it.
class Least {
public:
  explicit Least(int steps)
      : seconds_(static_cast<std::size_t>(steps) + 1, std::numeric_limits<double>::infinity()) {}
  void take(int k, double seconds) {
    double& least = seconds_[static_cast<std::size_t>(k)];
    least = std::min(least, seconds);
  }
  /// Mean over the steps that `which` picks; 0 if there is none.
  template <class Which>
  [[nodiscard]] double mean(Which&& which) const {
    double sum = 0;
    int count = 0;
    for (std::size_t k = 1; k < seconds_.size(); ++k)
      if (which(k))
        sum += seconds_[k], ++count;
    return count ? sum / count : 0;
  }

private:
  std::vector<double> seconds_;
};

/// The floor of one step: the same products and the same solve for the same solution, from the same guess, no
/// contact.
class Floor {
public:
  Floor(const problem::Problem& problem, const step::ForceAtStep& load)
      : problem_(problem), load_(load), r_(problem.space.vector()), y_(problem.space.vector()),
        f_(problem.space.vector()), guess_(problem.stepper) {
    guess_.remember(0, problem.initial.y());
  }

  /// Seconds of the solve and of the products at step k of a motion.
  std::pair<double, double> operator()(const test::Recorded& motion, int k) {
    const auto i = static_cast<std::size_t>(k);
    const step::Stepper& stepper = problem_.stepper;
    const step::Scheme scheme = problem_.grid.scheme(1);
    const step::NodalForce load = load_.at(problem_.grid.step(k));
    Watch watch;
    check(VecAXPBYPCZ(f_, scheme.momentum(), scheme.impulse() / *problem_.operators.uniform_density, 0,
                      motion.v[i - 1], load.density));
    watch.lap();
    check(MatMult(problem_.operators.M, f_, r_));
    double products = watch.lap();
    check(MatMultAdd(stepper.of_length(scheme.tau).R(), motion.y[i - 1], r_, r_));
    products += watch.lap();
    stepper.clamped().clear(r_);
    if (stepper.pairs())
      stepper.pairs()->rows().apply(-1, motion.contact[i].lambda, r_);
    guess_.guess(problem_.grid.time(k), y_);
    watch.lap();
    stepper.solver().linear().solve(r_, y_);
    const double solve = watch.lap();
    guess_.remember(problem_.grid.time(k), motion.y[i]);
    return {solve, products};
  }

private:
  const problem::Problem& problem_;
  const step::ForceAtStep& load_;
  petsc::Vector r_, y_, f_;
  trajectory::Extrapolation guess_;
};

double total(double mine) {
  MPI_Allreduce(MPI_IN_PLACE, &mine, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return mine;
}

nlohmann::ordered_json measure(const scene::Scene& scene, int repeats) {
  Timers timers;
  const problem::Problem problem(MPI_COMM_WORLD, scene, {.derivatives = true}, timers);
  const int steps = problem.steps();
  const double setup_peak = total(peak_memory()), setup_resident = total(resident_memory());
  problem::ControlProblem control_problem(problem, Console(false, false));
  control::ReducedProblem& reduced = control_problem.reduced;
  const control::Control u = control_problem.first_guess(scene);
  const control::ControlForce force(control_problem.controls, u);
  const step::ForceAtStep load = problem.load(&force), floor_load = problem.load(&force);

  reduced.simulate(u); // first, while nothing else takes memory
  reduced.accept();
  control::Control gradient = reduced.l2_gradient();
  const double gradient_peak = total(peak_memory());

  const test::Recorded motion(problem, load);
  Least forward(steps), adjoint(steps), solve(steps), products(steps), adjoint_floor(steps);
  Watch watch;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    Floor floor(problem, floor_load);
    watch.lap();
    trajectory::integrate(problem.stepper, problem.grid, problem.initial, load,
                          [&](const trajectory::Frame& frame) {
                            const double seconds = watch.lap();
                            if (frame.step.k > 0) {
                              forward.take(frame.step.k, seconds);
                              const auto [s, p] = floor(motion, frame.step.k);
                              solve.take(frame.step.k, s);
                              products.take(frame.step.k, p);
                            }
                            watch.lap();
                          });
  }
  const test::Displacements states(motion.y);
  const control::ObjectiveDuals derivative(control_problem.objective, states);
  step::Stepper::Workspace work = problem.stepper.workspace();
  for (int repeat = 0; repeat < repeats; ++repeat) {
    Floor floor(problem, floor_load);
    watch.lap();
    adjoint::sweep(problem.stepper, work, problem.grid, motion.sets(), {problem.space, derivative},
                   [&](int k, Vec p) {
                     axpy(1, petsc::ReadArray(p), gradient.at(k));
                     adjoint.take(k, watch.lap());
                     const auto [s, w] = floor(motion, k);
                     adjoint_floor.take(k, s + w);
                     watch.lap();
                   });
  }

  // Whole runs, as the optimizer makes them.
  double run = std::numeric_limits<double>::infinity(), whole = run;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    watch.lap();
    trajectory::integrate(problem.stepper, problem.grid, problem.initial, load,
                          [](const trajectory::Frame&) {});
    run = std::min(run, watch.lap());
    reduced.simulate(u);
    reduced.accept();
    gradient = reduced.l2_gradient();
    whole = std::min(whole, watch.lap());
  }

  const auto touching = [&](std::size_t k) { return !motion.contact[k].active.empty(); };
  const auto flying = [&](std::size_t k) { return motion.contact[k].active.empty(); };
  const auto every = [](std::size_t) { return true; };
  int contact_steps = 0, vi_steps = 0;
  for (std::size_t k = 1; k < motion.contact.size(); ++k) {
    contact_steps += touching(k);
    vi_steps += motion.contact[k].vi_iterations > 0;
  }
  const auto ratio = [&](double time, double floor) { return floor > 0 ? time / floor : 0; };
  const auto forward_ratio = [&](auto&& which) {
    return ratio(forward.mean(which), solve.mean(which) + products.mean(which));
  };
  const auto adjoint_ratio = [&](auto&& which) {
    return ratio(adjoint.mean(which), adjoint_floor.mean(which));
  };

  nlohmann::ordered_json out;
  const step::SolverChoice::Memory memory = problem.stepper.solver().memory();
  const double vectors = sizeof(PetscScalar) * static_cast<double>(problem.space.dofs());
  const double operators = operator_bytes(problem), trajectory_bytes = (steps + 1) * vectors,
               peak = total(peak_memory());
  out["scene"] = scene.name;
  out["size"] = scene.mesh.size.value_or(0);
  out["ranks"] = ranks(MPI_COMM_WORLD);
  out["dimension"] = problem.space.dim();
  out["free_unknowns"] = problem.free_dofs();
  out["candidates"] = problem.stepper.pairs() ? problem.stepper.pairs()->count() : 0;
  out["steps"] = steps;
  out["contact_steps"] = contact_steps;
  out["steps_with_set_changes"] = vi_steps;
  out["solver"] = problem.stepper.solver().choice();
  out["seconds"] = {{"solve", solve.mean(every)},
                    {"products", products.mean(every)},
                    {"forward_step", forward.mean(every)},
                    {"adjoint_step", adjoint.mean(every)},
                    {"forward_run", run},
                    {"gradient", whole}};
  for (const auto& [phase, entry] : timers.entries())
    out["setup_seconds"][phase] = entry.seconds;
  out["ratios"] = {{"contact_step", forward_ratio(touching)},
                   {"contact_free_step", forward_ratio(flying)},
                   {"adjoint_contact_step", adjoint_ratio(touching)},
                   {"adjoint_contact_free_step", adjoint_ratio(flying)},
                   {"gradient", whole / run}};
  out["bytes"] = {{"factor", memory.factor},
                  {"operators", operators},
                  {"condensation", memory.condensation},
                  {"trajectory", trajectory_bytes},
                  {"resident_after_setup", setup_resident},
                  {"peak_after_setup", setup_peak},
                  {"peak_of_gradient", gradient_peak},
                  {"peak", peak}};
  return out;
}

} // namespace

int main(int argc, char** argv) { return bench::run("signorini-bench", argc, argv, measure); }
