// SPDX-License-Identifier: GPL-3.0-or-later
#include "problem/scenarios.h"
#include "base/error.h"
#include "problem/operators_key.h"
#include "step/united.h"
#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <numeric>

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

/// Scene of a scenario with the solver of the scene itself, whose defaults depend on the machine.
scene::Scene with_solver(const scene::Scenario& scenario, const scene::Scene& nominal) {
  scene::Scene scene = *scenario.scene;
  scene.solver = nominal.solver;
  return scene;
}

} // namespace

std::size_t motions(const scene::Scene& scene) {
  return 1 + static_cast<std::size_t>(std::ranges::count_if(
                 scene.scenarios, [](const scene::Scenario& one) { return !one.set.empty(); }));
}

struct Scenarios::Parts {
  Parts(const Problem& nominal, const scene::Scenario& scenario, const Problem* like,
        const control::ControlSpace& controls, const control::Objective& objective_of_scene)
      : scene(with_solver(scenario, nominal.scene)),
        problem(nominal.discretisation, scene, nominal.needs, timers, trajectory::Stops::obeyed, like),
        storage(state_stores(problem, motions(nominal.scene))),
        objective(controls, problem.operators, problem.grid,
                  desired(problem, storage.in_memory(), objective_of_scene), scene),
        reduced({.stepper = &problem.stepper,
                 .initial = &problem.initial,
                 .storage = &storage,
                 .load = problem.scene_loads()},
                controls, objective, timers) {}

  Timers timers; // of their own, since tasks nest their phases independently
  scene::Scene scene;
  Problem problem;
  trajectory::StateStoreFactory storage;
  control::Objective objective;
  control::ReducedProblem reduced;
};

Scenarios::Scenarios(const Problem& nominal, const control::ControlSpace& controls,
                     const control::Objective& objective)
    : nominal_(nominal), controls_(controls), objective_(objective) {
  const scene::Scene& scene = nominal.scene;
  const auto virtual_nodes = [&](const scene::Scene& of) {
    return contact::virtual_nodes(of.contacts, nominal.mesh.dim(), nominal.mesh.axisymmetric()).size();
  };
  std::map<std::string, std::vector<const Problem*>> of_operators;
  of_operators[operators_key(scene, nominal.needs)].push_back(&nominal);
  for (std::size_t i = 0; i < scene.scenarios.size(); ++i) {
    const scene::Scenario& scenario = scene.scenarios[i];
    if (scenario.set.empty()) {
      numbers_.push_back(0);
      continue;
    }
    const std::string where = fmt::format("{}: {}.set", scene.file.string(), scene::scenario_key(i));
    if (virtual_nodes(*scenario.scene) != virtual_nodes(scene))
      throw UserError(where + ": found another number of obstacles with mass than in the scene; scenarios "
                              "may not change it");
    try {
      scene::require_dimension(*scenario.scene, nominal.mesh.dim());
      auto& same = of_operators[operators_key(with_solver(scenario, scene), nominal.needs)];
      parts_.push_back(std::make_unique<Parts>(nominal, scenario, same.empty() ? nullptr : same.front(),
                                               controls, objective));
      same.push_back(&parts_.back()->problem);
    } catch (const UserError& error) {
      throw UserError(fmt::format("{}: {}", where, error.what()));
    }
    numbers_.push_back(parts_.size());
  }
  constexpr std::size_t enough = 3; // solves for fewer, padded to the width of the kernels, save nothing
  for (const auto& [key, problems] : of_operators)
    if (problems.size() >= enough)
      shared_.push_back(&problems.front()->stepper);
}

Scenarios::~Scenarios() = default;

std::unique_ptr<control::ScenarioProblem> Scenarios::reduced(const control::Model& model) {
  const std::vector<scene::Scenario>& scenarios = nominal_.scene.scenarios;
  const double sum =
      std::accumulate(scenarios.begin(), scenarios.end(), 0.0,
                      [](double part, const scene::Scenario& one) { return part + one.weight; });
  std::vector<double> weights(parts_.size() + 1);
  for (std::size_t i = 0; i < scenarios.size(); ++i)
    weights[numbers_[i]] += scenarios[i].weight / sum;
  std::vector<control::ReducedProblem*> others;
  for (const std::unique_ptr<Parts>& parts : parts_)
    others.push_back(&parts->reduced);
  return std::make_unique<control::ScenarioProblem>(
      model, controls_, objective_, nominal_.timers, std::move(others), std::move(weights),
      nominal_.scene.objective->exponent,
      [this](const std::vector<std::function<void()>>& tasks) { run(tasks); });
}

void Scenarios::run(const std::vector<std::function<void()>>& tasks) {
  std::vector<std::unique_ptr<step::United>> united;
  bool together = false;
  for (const step::Stepper* stepper : shared_) {
    united.push_back(std::make_unique<step::United>(*stepper, stepper->first_length(), lockstep_));
    together = together || united.back()->solves();
  }
  if (together)
    return lockstep_.run(tasks);
  for (const std::function<void()>& task : tasks)
    task();
}

} // namespace signorini::problem
