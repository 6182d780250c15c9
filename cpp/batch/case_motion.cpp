// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/case_motion.h"
#include "base/error.h"
#include "base/text.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::batch {

std::vector<accuracy::Quantity> case_quantities(const scene::Scene& scene,
                                                const std::vector<std::string>& names, int dim) {
  std::vector<accuracy::Quantity> all = accuracy::quantities(scene, dim), wanted;
  std::erase_if(all, &accuracy::Quantity::field);
  if (names.empty()) {
    std::ranges::copy_if(all, std::back_inserter(wanted), [](const accuracy::Quantity& one) {
      return one.name != "energy_loss" && one.name != accuracy::of_stress;
    });
    return wanted;
  }
  std::vector<std::string> allowed;
  for (const accuracy::Quantity& one : all)
    allowed.push_back(one.name);
  for (const std::string& name : names) {
    const auto found = std::ranges::find(all, name, &accuracy::Quantity::name);
    if (found == all.end())
      throw UserError(fmt::format("--quantity: found \"{}\"{}; numbers of this scene: {}", name,
                                  suggestion(name, allowed), list(allowed)));
    if (std::ranges::find(wanted, name, &accuracy::Quantity::name) == wanted.end())
      wanted.push_back(*found);
  }
  return wanted;
}

CaseMotion::CaseMotion(std::shared_ptr<const problem::SpaceDiscretisation> discretisation,
                       const scene::Scene& scene, const std::vector<std::string>& quantities,
                       const CaseMotion* like)
    : scene_(scene), problem_(std::move(discretisation), scene_, problem::simulation_needs(scene_), timers_,
                              trajectory::Stops::obeyed, like ? &like->problem_ : nullptr),
      given_(problem_), wanted_(case_quantities(scene_, quantities, problem_.space.dim())) {}

Outcome CaseMotion::run() {
  try {
    return motion();
  } catch (const Interrupted&) {
    return {.reason = "interrupted", .interrupted = true};
  } catch (const UserError& error) {
    return {.reason = error.what()};
  } catch (const SolverFailure& error) {
    return {.reason = error.what()};
  }
}

Outcome CaseMotion::motion() {
  accuracy::MotionQuantities quantities(problem_, wanted_, nullptr);
  std::optional<problem::RunObjective> objective;
  if (scene_.objective && accuracy::has(wanted_, "J"))
    objective.emplace(problem_, given_);
  std::optional<ProbeFigures> probes;
  if (problem_.probes)
    probes.emplace(problem_, given_.acts());
  accuracy::simulate(problem_, given_.load(), [&](const trajectory::Frame& frame) {
    quantities(frame);
    if (objective)
      objective->observe(frame);
    if (probes)
      probes->observe(frame);
  });
  accuracy::Measured measured;
  quantities.report(measured);
  if (objective)
    measured.numbers["J"] = objective->value().total();
  Outcome outcome{.steps = problem_.steps()};
  for (const accuracy::Quantity& one : wanted_)
    if (const auto found = measured.numbers.find(one.name); found != measured.numbers.end())
      outcome.numbers.emplace_back(one.name, found->second);
  if (probes)
    std::ranges::move(probes->numbers(), std::back_inserter(outcome.numbers));
  return outcome;
}

} // namespace signorini::batch
