// SPDX-License-Identifier: GPL-3.0-or-later
#include "problem/scenarios.h"
#include "base/error.h"
#include <algorithm>
#include <fmt/format.h>
#include <numeric>

namespace signorini::problem {

std::size_t motions(const scene::Scene& scene) {
  return 1 + static_cast<std::size_t>(std::ranges::count_if(
                 scene.scenarios, [](const scene::Scenario& one) { return !one.set.empty(); }));
}

Scenarios::Scenarios(const Problem& nominal, const control::ControlSpace& controls,
                     const control::Objective& objective)
    : nominal_(nominal), controls_(controls), objective_(objective), others_(nominal, controls, objective) {
  const scene::Scene& scene = nominal.scene;
  const auto virtual_nodes = [&](const scene::Scene& of) {
    return contact::virtual_nodes(of.contacts, nominal.mesh.dim(), nominal.mesh.axisymmetric()).size();
  };
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
      others_.add(*scenario.scene, motions(scene));
    } catch (const UserError& error) {
      throw UserError(fmt::format("{}: {}", where, error.what()));
    }
    numbers_.push_back(others_.size());
  }
}

std::unique_ptr<control::ScenarioProblem> Scenarios::reduced(const control::Model& model) {
  const std::vector<scene::Scenario>& scenarios = nominal_.scene.scenarios;
  const double sum =
      std::accumulate(scenarios.begin(), scenarios.end(), 0.0,
                      [](double part, const scene::Scenario& one) { return part + one.weight; });
  std::vector<double> weights(others_.size() + 1);
  for (std::size_t i = 0; i < scenarios.size(); ++i)
    weights[numbers_[i]] += scenarios[i].weight / sum;
  std::vector<control::ReducedProblem*> others;
  for (std::size_t i = 0; i < others_.size(); ++i)
    others.push_back(&others_[i]);
  return std::make_unique<control::ScenarioProblem>(
      model, controls_, objective_, nominal_.timers, std::move(others), std::move(weights),
      nominal_.scene.objective->exponent,
      [this](const std::vector<std::function<void()>>& tasks) { others_.run(tasks); });
}

} // namespace signorini::problem
