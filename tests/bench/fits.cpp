// SPDX-License-Identifier: GPL-3.0-or-later
// Seconds of a gradient by a scene's unknowns over those of one by a control alone, on the same motion: a
// forward run whose states are kept, and the backward sweep; and those of a forward run with the derivatives
// of the motion by all unknowns, as in a Gauss-Newton step, over those of a forward run. Factors are made
// before.
//
// usage: signorini-bench-fits SCENE REPEATS [key.path=value …]    prints one JSON object
#include "adjoint/sweep.h"
#include "bench.h"
#include "control/measurements.h"
#include "trajectory/parameter_sensitivities.h"

using namespace signorini;

namespace {

/// Dual of the displacements: something that every step has.
class Pull final : public step::StateDuals {
public:
  explicit Pull(Vec dual) : dual_(dual) {}
  [[nodiscard]] bool has_density() const override { return false; }
  [[nodiscard]] bool has_vector() const override { return true; }
  void add(const step::TimeStep&, step::StateDual sum) const override {
    petsc::check(VecAXPY(sum.vector, 1, dual_));
  }

private:
  Vec dual_;
};

nlohmann::ordered_json measure(const scene::Scene& scene, int repeats) {
  Timers timers;
  const problem::Problem problem(MPI_COMM_WORLD, scene, {.derivatives = true}, timers);
  const int steps = problem.steps();
  const problem::GivenControl given(problem);
  const trajectory::StateStoreFactory storage(problem.stepper, problem.grid, scene.trajectory, 1, timers);
  const petsc::Vector dual = problem.space.vector();
  petsc::check(VecSet(dual, 1));
  const Pull pull(dual);
  const step::DualAtStep derivative(problem.space, pull);
  const std::vector<double> values = scene::start_values(scene);
  step::ParameterRates rates(problem.stepper, scene, values);
  std::vector<double> times;
  for (int k = 1; k <= steps; ++k)
    times.push_back(problem.grid.time(k));
  control::Measurements measurements(problem.stepper, problem.grid, scene,
                                     std::vector(scene.measurements.size(), times));
  step::Stepper::Workspace work = problem.stepper.workspace();
  const double infinity = std::numeric_limits<double>::infinity();
  double control_alone = infinity, unknowns = infinity, forward = infinity, jacobian = infinity;
  int touching = 0;
  std::vector<double> gradient;
  Watch watch;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    {
      trajectory::Trajectory motion(problem.stepper, problem.initial, storage);
      watch.lap();
      motion.run(given.load());
      adjoint::sweep(problem.stepper, work, problem.grid, motion.contact(), derivative, [](int, Vec) {});
      control_alone = std::min(control_alone, watch.lap());
    }
    trajectory::Trajectory motion(problem.stepper, problem.initial, storage, true);
    watch.lap();
    motion.run(given.load(), [&](const trajectory::Frame& frame) { measurements.observe(frame); });
    measurements.set_derivative(std::vector<double>(measurements.count(), 1.0));
    gradient =
        adjoint::sweep(problem.stepper, work, motion, {problem.space, measurements}, measurements, rates);
    unknowns = std::min(unknowns, watch.lap());
    watch.lap();
    trajectory::integrate(problem.stepper, problem.grid, problem.initial, given.load(),
                          [](const trajectory::Frame&) {});
    forward = std::min(forward, watch.lap());
    trajectory::ParameterSensitivities sensitivities(problem.stepper, rates);
    watch.lap();
    trajectory::integrate(problem.stepper, problem.grid, problem.initial, given.load(),
                          [&](const trajectory::Frame& frame) { sensitivities.observe(frame); });
    jacobian = std::min(jacobian, watch.lap());
    touching = static_cast<int>(
        std::ranges::count_if(motion.contact(), [](const auto& sets) { return !sets.active.empty(); }));
  }
  return {{"free_unknowns", problem.free_dofs()},
          {"steps", steps},
          {"contact_steps", touching},
          {"parameters", gradient.size()},
          {"seconds",
           {{"control_alone", control_alone},
            {"parameters", unknowns},
            {"forward", forward},
            {"jacobian", jacobian}}},
          {"ratio", unknowns / control_alone},
          {"jacobian_ratio", jacobian / forward}};
}

} // namespace

int main(int argc, char** argv) { return bench::run("signorini-bench-fits", argc, argv, measure); }
