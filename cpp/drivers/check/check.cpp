// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/check/check.h"
#include "base/error.h"
#include "diagnostics/balance.h"
#include "drivers/check/derivative_check.h"
#include "drivers/check/evaluation_point.h"
#include "drivers/check/fit_check.h"
#include "drivers/run_manifest.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::drivers {

namespace {

/// Collects statistics of contact over a motion, frame by frame.
class ContactWatch {
public:
  explicit ContactWatch(const step::Stepper& stepper)
      : pairs_(*stepper.pairs()), gaps_(pairs_.gaps()), before_(pairs_.psi().begin(), pairs_.psi().end()) {}

  void observe(const trajectory::Frame& frame, double contact_work) {
    if (frame.step.k == 0)
      return;
    const contact::ContactState& state = frame.contact;
    const int strong = state.count(contact::Status::strong);
    steps += strong > 0;
    weak += state.count(contact::Status::weak);
    most = std::max(most, strong);
    slips += state.count(contact::Motion::slips);
    sticks += state.count(contact::Motion::sticks);
    projected += !state.predictor.empty();
    if (pairs_.moving()) {
      const std::span<const double> psi = pairs_.psi(frame.step.end, gaps_);
      for (std::size_t i = 0; i < psi.size(); ++i)
        contact_work += state.lambda[i] / frame.step.scheme().impulse() * (psi[i] - before_[i]);
      before_.assign(psi.begin(), psi.end());
    }
    work = std::max(work, contact_work);
  }

  int steps = 0, weak = 0, most = 0, projected = 0, slips = 0, sticks = 0;
  /// Largest work of contact in a step, without the work of the obstacles' motion, −2/τ² λ_k·(ψ_k − ψ_{k−1}).
  /// In theory the difference is −2/τ² λ_k·g(y_{k−1}) ≤ 0 (docs/method.md section 2).
  double work = 0;

private:
  const contact::ContactPairs& pairs_;
  contact::ContactPairs::Gaps gaps_;
  std::vector<double> before_;
};

/// Simulates a motion and adds rows for its energy law, momentum, complementarity and contact. Throws
/// Interrupted.
void invariants(const problem::Problem& problem, const step::ForceAtStep& load, std::vector<CheckRow>& rows) {
  const contact::ContactPairs* pairs = problem.stepper.pairs();
  std::optional<ContactWatch> contact;
  if (pairs)
    contact.emplace(problem.stepper);
  diagnostics::Balance weigh(problem.stepper);
  diagnostics::Invariants watch(problem.stepper, diagnostics::body_figures(problem.stepper, problem.scene));
  const int done = trajectory::integrate(
      problem.stepper, problem.grid, problem.initial, load, [&](const trajectory::Frame& frame) {
        const diagnostics::StepBalance balance = weigh(frame);
        watch.observe(frame, balance);
        if (contact)
          contact->observe(frame, balance.contact_work - balance.belt_work);
      });
  if (done < problem.steps())
    throw Interrupted();
  const double tolerance = problem.scene.run.tolerance, energy = watch.largest_energy();
  rows.push_back({"the body moved (largest energy)", fmt::format("{:.2e}", energy), "> 0", energy > 0});
  if (!(energy > 0)) {
    rows.back().measured += problem.scene.objective ? ": give check.control another value" : "";
    return;
  }
  for (const diagnostics::Invariants::Defect& defect : watch.defects())
    rows.push_back(below(defect.name, defect.worst, tolerance));
  if (!contact)
    return;
  const std::string occurred =
      contact->steps == 0 ? "never; contact is not checked"
      : problem.stepper.frictional()
          ? fmt::format("{} steps, up to {} candidates, {} weak, {} slip, {} stick", contact->steps,
                        contact->most, contact->weak, contact->slips, contact->sticks)
          : fmt::format("{} steps, up to {} candidates each, weak contact {} times", contact->steps,
                        contact->most, contact->weak);
  rows.push_back({"contact occurred", occurred, "in at least one step", contact->steps > 0});
  // Predictors move without forces: for a body that stays in contact they may never enter an obstacle.
  const bool rests = contact->steps == problem.steps();
  if (problem.stepper.predictor() && (contact->projected > 0 || !rests))
    rows.push_back({"the predictor was projected", fmt::format("in {} steps", contact->projected),
                    "in at least one step", contact->projected > 0});
  if (contact->steps == 0)
    return;
  rows.push_back(below(pairs->moving() ? "largest contact work without obstacles' motion / energy"
                                       : "largest positive contact work in a step / largest energy",
                       contact->work / energy, tolerance));
}

} // namespace

bool check_scene(problem::Problem& problem, const Console& console) {
  problem::choose_steps(problem, console);
  const scene::Scene& scene = problem.scene;
  std::vector<CheckRow> rows;
  std::string advice;
  if (scene.contacts.empty())
    console.line("The scene has no contact: the checks are those of a linear problem.");
  if (!scene.unknowns.empty()) {
    problem::ParameterProblem fit(problem.discretisation, scene, problem.timers);
    print_table_warnings(fit.misfit.warnings(), console);
    check_fit(fit, problem.stepper.solver().tolerance(), console, rows);
    const scene::Scene start = fit.scene_at(fit.misfit.start());
    const problem::Problem started(problem.discretisation, start, problem::check_needs(scene),
                                   problem.timers);
    const problem::GivenControl given(started);
    invariants(started, given.load(), rows);
    if (scene.objective) {
      const problem::ControlProblem control(problem, console);
      problem::ParameterProblem joint(problem.discretisation, scene, problem.timers, &control);
      joint.reduced.weigh_parameters({control.first_guess(scene), joint.misfit.start()});
      check_joint(joint.reduced, problem.stepper.solver().tolerance(), rows);
    }
  } else if (scene.objective) {
    problem::ControlProblem control_problem(problem, console);
    std::string where;
    const control::Control u = evaluation_point(problem, control_problem, where);
    console.line(fmt::format("Derivatives are checked at {}.", where));
    advice =
        check_derivatives(control_problem.reduced, u, problem.stepper.solver().tolerance(), console, rows);
    invariants(problem, control_problem.reduced.load(), rows);
  } else {
    console.line("The scene has no objective: there are no derivatives to check.");
    const problem::GivenControl given(problem);
    invariants(problem, given.load(), rows);
  }
  console.line(fmt::format("{:<6}{:<58}{:<64}{}", "", "check", "measured", "limit"));
  bool all = true;
  for (const CheckRow& row : rows) {
    console.line(
        fmt::format("{:<6}{:<58}{:<64}{}", row.holds ? "ok" : "FAIL", row.name, row.measured, row.allowed));
    all = all && row.holds;
  }
  console.line(all ? (scene.contacts.empty() ? "All checks hold; contact was not checked."
                                             : "All checks hold, contact included.")
                   : "A check failed.");
  if (all && !advice.empty())
    console.line(
        "But the derivatives hold only for changes of the control that are too small for a search: " +
        advice + ".");
  return all;
}

} // namespace signorini::drivers
