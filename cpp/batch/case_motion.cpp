// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/case_motion.h"
#include "base/error.h"
#include <algorithm>

namespace signorini::batch {

std::vector<accuracy::Quantity> case_quantities(const scene::Scene& scene,
                                                const std::vector<std::string>& names, int dim) {
  std::vector<accuracy::Quantity> all = accuracy::quantities(scene, dim);
  std::erase_if(all, &accuracy::Quantity::field);
  if (!names.empty())
    return accuracy::named(all, names, "numbers");
  std::erase_if(all, [](const accuracy::Quantity& one) {
    return one.name == "energy_loss" || one.name == accuracy::of_stress;
  });
  return all;
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
