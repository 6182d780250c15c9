// SPDX-License-Identifier: GPL-3.0-or-later
// What the effects of a scene cost: seconds per step of a forward run and of a gradient, solves, matrices and
// memory; and, where the scene has neither contact nor loads, the same motion by a loop that has never heard
// of them.
//
// usage: signorini-bench-effects SCENE REPEATS [key.path=value …]    prints one JSON object
#include "base/timers.h"
#include "bench.h"

using namespace signorini;
using petsc::check;

namespace {

/// The motion of a clamped body and no more: two products, a solve and the velocity, written out.
class BareLoop {
public:
  explicit BareLoop(const problem::Problem& problem)
      : problem_(problem), y0_(problem.space.vector()), v0_(petsc::zero_like(y0_)),
        y1_(petsc::zero_like(y0_)), v1_(petsc::zero_like(y0_)), r_(petsc::zero_like(y0_)),
        work_(petsc::zero_like(y0_)) {}

  /// The last displacement.
  Vec operator()() {
    const double tau = problem_.scene.time.step;
    Mat M = problem_.operators.M, R = problem_.stepper.of_length(problem_.grid.length(1)).R();
    const LinearSolver& D = problem_.stepper.solver().linear();
    const std::vector<int>& clamped = problem_.stepper.clamped().dofs();
    check(VecCopy(problem_.initial.y(), y0_));
    check(VecCopy(problem_.initial.v(), v0_));
    for (int k = 1; k <= problem_.steps(); ++k) {
      check(VecAXPBY(work_, tau, 0, v0_));
      check(MatMult(M, work_, r_));
      check(MatMultAdd(R, y0_, r_, r_));
      {
        const petsc::WriteArray r(r_);
        for (int dof : clamped)
          r[static_cast<std::size_t>(dof)] = 0;
      }
      D.solve(r_, y1_);
      {
        const petsc::ReadArray from(y0_), to(y1_), before(v0_);
        const petsc::WriteArray after(v1_);
        for (std::size_t i = 0; i < after.size(); ++i)
          after[i] = 2 / tau * (to[i] - from[i]) - before[i];
      }
      std::swap(y0_, y1_);
      std::swap(v0_, v1_);
    }
    return y0_;
  }

private:
  const problem::Problem& problem_;
  petsc::Vector y0_, v0_, y1_, v1_, r_, work_;
};

nlohmann::ordered_json measure(const scene::Scene& scene, int repeats) {
  Timers timers;
  const bool controlled = scene.objective.has_value();
  const problem::Problem problem(MPI_COMM_WORLD, scene, {.derivatives = controlled}, timers);
  std::optional<problem::ControlProblem> control_problem;
  std::optional<problem::GivenControl> given;
  if (controlled)
    control_problem.emplace(problem, Console(false, false));
  else
    given.emplace(problem);
  const auto load = [&] { return controlled ? control_problem->reduced.load() : given->load(); };
  std::optional<BareLoop> bare;
  if (scene.contacts.empty() && !load().at(problem.grid.step(1)).density &&
      !load().at(problem.grid.step(1)).vector)
    bare.emplace(problem);

  constexpr double never = std::numeric_limits<double>::infinity();
  double run = never, bare_run = never, gradient = never, iteration = never;
  long run_solves = 0, gradient_solves = 0;
  int contact_steps = 0;
  petsc::Vector last = problem.space.vector();
  Watch watch;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    long before = count("solves with D");
    if (!controlled) {
      watch.lap();
      trajectory::integrate(problem.stepper, problem.grid, problem.initial, load(),
                            [](const trajectory::Frame&) {});
      run = std::min(run, watch.lap());
      run_solves = count("solves with D") - before;
      if (bare) {
        watch.lap();
        const Vec y = (*bare)();
        bare_run = std::min(bare_run, watch.lap());
        check(VecCopy(y, last));
      }
      continue;
    }
    control::ReducedProblem& reduced = control_problem->reduced;
    control::Control u = control_problem->first_guess(scene);
    watch.lap();
    reduced.simulate(u);
    reduced.accept();
    const double forward = watch.lap();
    run_solves = count("solves with D") - before;
    control::Control g = reduced.gradient().u;
    const double whole = forward + watch.lap();
    gradient_solves = count("solves with D") - before;
    u.add(-1, g);
    control::Variables v(u);
    reduced.project(v);
    (void)reduced.inner(g, g);
    run = std::min(run, forward);
    gradient = std::min(gradient, whole);
    iteration = std::min(iteration, whole + watch.lap());
  }

  // Once more, looked at: whether contact occurred, and that the bare loop moves the body alike.
  double difference = 0;
  trajectory::integrate(problem.stepper, problem.grid, problem.initial, load(),
                        [&](const trajectory::Frame& frame) {
                          contact_steps += !frame.contact.active.empty();
                          if (!frame.last || !bare)
                            return;
                          PetscReal size = 0;
                          check(VecNorm(frame.after.y(), NORM_2, &size));
                          check(VecAXPY(last, -1, frame.after.y()));
                          check(VecNorm(last, NORM_2, &difference));
                          difference /= size;
                        });

  const auto per_step = [&](double seconds) -> nlohmann::json {
    return seconds < never ? nlohmann::json(seconds / problem.steps()) : nlohmann::json();
  };
  nlohmann::ordered_json out;
  const step::SolverChoice::Memory memory = problem.stepper.solver().memory();
  out["free_unknowns"] = problem.free_dofs();
  out["steps"] = problem.steps();
  out["contact_steps"] = contact_steps;
  out["seconds_per_step"] = {{"forward", per_step(run)},
                             {"bare", per_step(bare_run)},
                             {"gradient", per_step(gradient)},
                             {"iteration", per_step(iteration)}};
  out["difference_to_bare"] = bare ? nlohmann::json(difference) : nlohmann::json();
  out["solves"] = {{"forward", run_solves}, {"gradient", gradient_solves}};
  out["bytes"] = {{"factor", memory.factor},
                  {"operators", operator_bytes(problem)},
                  {"condensation", memory.condensation}};
  out["peak_bytes"] = peak_memory();
  out["counters"] = counts();
  return out;
}

} // namespace

int main(int argc, char** argv) { return bench::run("signorini-bench-effects", argc, argv, measure); }
