// SPDX-License-Identifier: GPL-3.0-or-later
#include "problem/motion_set.h"
#include "problem/operators_key.h"
#include "step/united.h"

namespace signorini::problem {

namespace {

/// The desired motion of another objective.
class SameDesired final : public step::Displacements {
public:
  explicit SameDesired(const control::Objective& of) : of_(of) {}
  [[nodiscard]] Vec y(const step::TimeStep& step) const override { return of_.desired(step.k); }

private:
  const control::Objective& of_;
};

std::unique_ptr<const step::Displacements> desired(const Problem& problem, bool keep,
                                                   const control::Objective& nominal) {
  if (std::holds_alternative<scene::DesiredControl>(problem.scene.objective->desired))
    return std::make_unique<SameDesired>(nominal);
  return given_motion(problem, keep);
}

/// Returns a scene with the solver of another, whose defaults depend on the machine, without scenarios and
/// output.
scene::Scene prepared(scene::Scene scene, const scene::Scene& first) {
  scene.solver = first.solver;
  scene.scenarios.clear();
  scene.output.probes.clear();
  return scene;
}

} // namespace

struct MotionSet::Parts {
  Parts(const Problem& first, const scene::Scene& given, std::size_t motions, const Problem* like,
        const control::ControlSpace& controls, const control::Objective& objective_of_first)
      : scene(given),
        problem(first.discretisation, scene, first.needs, timers, trajectory::Stops::obeyed, like) {
    problem.grid = first.grid;
    storage.emplace(state_stores(problem, motions));
    objective.emplace(controls, problem.operators, problem.grid,
                      desired(problem, storage->in_memory(), objective_of_first), scene);
    const control::Model model{.stepper = &problem.stepper,
                               .initial = &problem.initial,
                               .storage = &*storage,
                               .load = problem.scene_loads()};
    reduced.emplace(model, controls, *objective, timers);
  }

  Timers timers; // of their own, since tasks nest their phases independently
  scene::Scene scene;
  Problem problem;
  std::optional<trajectory::StateStoreFactory> storage;
  std::optional<control::Objective> objective;
  std::optional<control::ReducedProblem> reduced;
};

MotionSet::MotionSet(const Problem& first, const control::ControlSpace& controls,
                     const control::Objective& objective)
    : first_(first), controls_(controls), objective_(objective) {
  of_operators_[operators_key(first.scene, first.needs)].push_back(&first);
}

MotionSet::~MotionSet() = default;

control::ReducedProblem& MotionSet::add(const scene::Scene& scene, std::size_t motions) {
  const scene::Scene own = prepared(scene, first_.scene);
  std::vector<const Problem*>& same = of_operators_[operators_key(own, first_.needs)];
  parts_.push_back(std::make_unique<Parts>(first_, own, motions, same.empty() ? nullptr : same.front(),
                                           controls_, objective_));
  same.push_back(&parts_.back()->problem);
  return *parts_.back()->reduced;
}

control::ReducedProblem& MotionSet::operator[](std::size_t i) { return *parts_[i]->reduced; }

void MotionSet::run(const std::vector<std::function<void()>>& tasks) {
  constexpr std::size_t enough = 3; // solves for fewer, padded to the width of the kernels, save nothing
  std::vector<std::unique_ptr<step::United>> united;
  bool together = false;
  if (first_.grid.equal())
    for (const auto& [key, problems] : of_operators_)
      if (problems.size() >= enough) {
        const step::Stepper& stepper = problems.front()->stepper;
        united.push_back(std::make_unique<step::United>(stepper, stepper.first_length(), lockstep_));
        together = together || united.back()->solves();
      }
  if (together)
    return lockstep_.run(tasks);
  for (const std::function<void()>& task : tasks)
    task();
}

} // namespace signorini::problem
