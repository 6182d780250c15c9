// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/blocks.h"
#include "base/error.h"
#include "problem/operators_key.h"
#include "step/united.h"
#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <map>

namespace signorini::batch {

namespace {

std::string operators_of(const scene::Scene& scene) {
  return problem::operators_key(scene, problem::simulation_needs(scene));
}

/// Text of all of a scene that determines its SpaceDiscretisation.
std::string mesh_of(const scene::Scene& scene) {
  const scene::Mesh& mesh = scene.mesh;
  constexpr int space = 3;
  return fmt::format("{} {} {} {} {} {} {}", mesh.file.string(), mesh.size.value_or(-1), mesh.scale,
                     static_cast<int>(mesh.unit), mesh.degree,
                     mesh.model ? static_cast<int>(*mesh.model) : -1,
                     contact::virtual_nodes(scene.contacts, space, false).size());
}

} // namespace

std::vector<Block> blocks(const std::vector<Case>& cases, std::span<const std::size_t> wanted,
                          std::size_t most) {
  std::map<std::string, std::size_t> group_of;
  std::vector<Block> groups, divided;
  for (const std::size_t i : wanted) {
    const auto [found, is_new] = group_of.try_emplace(operators_of(*cases[i].scene), groups.size());
    if (is_new)
      groups.emplace_back();
    groups[found->second].push_back(i);
  }
  for (const Block& group : groups)
    for (std::size_t first = 0; first < group.size(); first += most) {
      const auto begin = group.begin() + static_cast<std::ptrdiff_t>(first);
      divided.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(std::min(most, group.size() - first)));
    }
  return divided;
}

void BlockRunner::discretise(const scene::Scene& scene) {
  const std::string mesh = mesh_of(scene);
  if (discretisation_ && mesh == mesh_)
    return;
  leader_.reset();
  discretisation_ = std::make_shared<const problem::SpaceDiscretisation>(MPI_COMM_SELF, scene, timers_);
  mesh_ = mesh;
}

void BlockRunner::follow(const std::string& key) {
  if (key != key_)
    leader_.reset();
  key_ = key;
}

std::vector<Outcome> BlockRunner::run(const Block& block) {
  std::vector<Outcome> outcomes(block.size());
  std::vector<std::unique_ptr<CaseMotion>> own;
  std::vector<std::function<void()>> tasks;
  for (std::size_t i = 0; i < block.size(); ++i)
    try {
      const scene::Scene& scene = *cases_[block[i]].scene;
      discretise(scene);
      scene::require_dimension(scene, discretisation_->mesh.dim());
      follow(operators_of(scene));
      auto made = std::make_unique<CaseMotion>(discretisation_, scene, quantities_, leader_.get());
      std::unique_ptr<CaseMotion>& place = leader_ ? own.emplace_back() : leader_;
      place = std::move(made);
      CaseMotion& motion = *place;
      known_ = motion.quantities();
      const std::filesystem::path* folder = folders_.empty() ? nullptr : &folders_[block[i]];
      tasks.emplace_back([&motion, folder, &outcome = outcomes[i]] { outcome = motion.run(folder); });
    } catch (const Interrupted&) {
      outcomes[i] = {.reason = "interrupted", .interrupted = true};
    } catch (const UserError& error) {
      outcomes[i] = {.reason = error.what()};
    } catch (const SolverFailure& error) {
      outcomes[i] = {.reason = error.what()};
    }
  if (tasks.empty())
    return outcomes;
  std::optional<step::United> united;
  if (const problem::Problem& problem = leader_->problem(); problem.grid.equal())
    united.emplace(problem.stepper, problem.stepper.first_length(), lockstep_);
  if (united && united->solves())
    lockstep_.run(tasks);
  else
    for (const std::function<void()>& task : tasks)
      task();
  return outcomes;
}

} // namespace signorini::batch
