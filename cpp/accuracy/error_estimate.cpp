// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/error_estimate.h"
#include "accuracy/rungs.h"
#include "base/error.h"
#include "control/interpolation.h"
#include "diagnostics/warnings.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::accuracy {
using petsc::check;

namespace {

/// Loads of a scene and forces of its controls, in finite-element functions of degree 2.
class EnrichedLoads {
public:
  EnrichedLoads(const adjoint::EnrichedBody& body, const problem::Problem& problem,
                const control::ControlSpace& controls)
      : body_(body), coarse_(controls),
        controls_(body.space(), body.operators(), problem.grid, *problem.scene.control),
        coarse_field_(controls.field()), field_(controls_.field()), values_(controls_.size()) {
    if (problem.scene.load)
      load_.emplace(body.space(), body.operators().M, *problem.scene.load, problem.stepper.end());
  }

  /// Sum of the scene's loads and of `force`, the force of a control; valid as long as `force`.
  [[nodiscard]] step::ForceAtStep with(const step::Load& force) const {
    return {body_.space(), {load_ ? &*load_ : nullptr, &force}};
  }

  /// Force of one of the run's controls on the enriched body, whose functions have degree 2.
  class Force final : public step::Load {
  public:
    Force(const EnrichedLoads& loads, const control::Control& u) : loads_(loads), u_(u) {}
    [[nodiscard]] bool has_density() const override { return loads_.controls_.acts_by_density(); }
    [[nodiscard]] bool has_vector() const override { return !has_density(); }
    void add(const step::TimeStep& step, step::NodalForce sum) const override {
      loads_.controls_.for_each_interval(step, [&](int j, double part) {
        loads_.controls_.add_force(loads_.enriched(u_.at(j)), sum, part);
      });
    }

  private:
    const EnrichedLoads& loads_;
    const control::Control& u_;
  };

private:
  std::span<const double> enriched(std::span<const double> u) const {
    if (controls_.cellwise())
      return u;
    coarse_.extend(u, coarse_field_);
    body_.embed(coarse_field_, field_);
    controls_.restrict(field_, values_);
    return values_;
  }

  const adjoint::EnrichedBody& body_;
  const control::ControlSpace& coarse_;
  control::ControlSpace controls_;
  petsc::Vector coarse_field_, field_;
  mutable std::vector<double> values_; ///< buffer
  std::optional<step::SceneLoad> load_;
};

/// Direct effect of the interpolation errors of initial and desired displacement on the state part of J,
/// Σ_k ½ weight(k) ‖y_k − y_d,k‖², in functions of degree 2.
class EnrichedObjective {
public:
  EnrichedObjective(const adjoint::EnrichedBody& body, const problem::Problem& problem,
                    const control::Objective& objective)
      : body_(body), problem_(problem), objective_(objective), coarse_(problem.space.vector()),
        distance_(body.space().vector()), sum_(body.space().vector()), product_(body.space().vector()),
        off_(body.space().vector()) {
    const scene::Objective& scene = *problem.scene.objective;
    if (scene.on)
      own_ = fem::assemble_L2(body.space(), *scene.on, "objective.on");
    if (const auto* desired = std::get_if<scene::DesiredDisplacement>(&scene.desired)) {
      desired_.emplace(desired->displacement, "objective.desired.displacement", true);
      body_.interpolation_error(*desired_, 0, off_);
    }
  }

  void observe(int k, Vec y) {
    const double weight = objective_.weight(k);
    const Vec initial = k == 0 ? Vec(body_.initial_error().y) : nullptr;
    if (weight == 0 || !(desired_ || initial))
      return;
    check(VecWAXPY(coarse_, -1, objective_.desired(k), y));
    body_.embed(coarse_, distance_);
    if (initial)
      parts.initial += weight / 2 * change(initial, 1);
    if (!desired_)
      return;
    if (k > 0 && desired_->depends_on_time())
      body_.interpolation_error(*desired_, problem_.grid.time(k), off_);
    parts.desired += weight / 2 * change(off_, -1);
  }

  adjoint::ErrorParts parts;

  /// Derivatives ∂J/∂y_k along a motion, on the enriched body.
  class Derivative final : public step::StateDuals {
  public:
    Derivative(const EnrichedObjective& objective, const trajectory::Trajectory& motion)
        : objective_(objective), motion_(motion) {}
    [[nodiscard]] bool has_density() const override { return !objective_.own_; }
    [[nodiscard]] bool has_vector() const override { return !has_density(); }
    void add(const step::TimeStep& step, step::StateDual sum) const override {
      const EnrichedObjective& o = objective_;
      const int k = step.k;
      check(VecWAXPY(o.coarse_, -1, o.objective_.desired(k), motion_.y(step)));
      o.body_.embed(o.coarse_, o.distance_);
      check(VecScale(o.distance_, o.objective_.weight(k)));
      if (o.own_)
        check(MatMultAdd(o.own_, o.distance_, sum.vector, sum.vector));
      else
        check(VecAXPY(sum.density, 1, o.distance_));
    }

  private:
    const EnrichedObjective& objective_;
    const trajectory::Trajectory& motion_;
  };

private:
  /// Difference ‖e + sign d‖² − ‖e‖² for e = y − y_d.
  double change(Vec d, double sign) {
    check(VecWAXPY(sum_, 2 * sign, distance_, d));
    check(MatMult(own_ ? Mat(own_) : Mat(*body_.operators().W), sum_, product_));
    return petsc::dot(d, product_);
  }

  const adjoint::EnrichedBody& body_;
  const problem::Problem& problem_;
  const control::Objective& objective_;
  petsc::Matrix own_;
  std::optional<scene::Field> desired_;
  petsc::Vector coarse_, distance_, sum_, product_, off_;
};

/// Subtracts `other` from `parts`.
void subtract(const adjoint::ErrorParts& other, adjoint::ErrorParts& parts) {
  parts.time -= other.time;
  parts.initial -= other.initial;
  if (parts.space)
    *parts.space -= *other.space;
}

} // namespace

std::string not_estimated(const scene::Scene& scene) {
  if (!scene.scenarios.empty())
    return "[[scenario]], since the error estimate is that of one motion";
  if (scene.relaxes())
    return "material.prony, since the error estimate does not include relaxation";
  if (scene.rigid())
    return "contact.obstacle.mass, since the error estimate does not include the obstacle's motion";
  if (scene.several_bodies())
    return "contact.against, since the error estimate does not include contact between parts";
  if (scene.frictional())
    return "contact.friction, since the error estimate does not include slip";
  return "";
}

void require_estimable(const scene::Scene& scene, const char* option, const char* instead) {
  if (const std::string reason = not_estimated(scene); !reason.empty())
    throw UserError(fmt::format("{}: cannot be combined with {}; {}", option, reason, instead));
}

adjoint::ErrorParts estimate_error(const problem::Problem& problem,
                                   const problem::ControlProblem& control_problem,
                                   std::vector<double>* by_cells) {
  const step::Stepper& stepper = problem.stepper;
  const control::ReducedProblem& reduced = control_problem.reduced;
  std::optional<adjoint::EnrichedBody> body;
  std::optional<EnrichedLoads> loads;
  std::optional<EnrichedObjective> objective;
  if (problem.space.degree() == 1) {
    body.emplace(problem.space, stepper.pairs(), problem.scene);
    loads.emplace(*body, problem, control_problem.controls);
    objective.emplace(*body, problem, control_problem.objective);
  }
  // Separate trajectories, since velocities are needed. The desired motion is weighted with ∂J/∂y_k along the
  // current control's motion, so that both are read at the same time.
  const auto run = [&](trajectory::Trajectory& trajectory, const control::ControlForce& u,
                       const trajectory::StepObserver& watch) {
    trajectory.run(problem.load(&u), watch);
    if (trajectory.steps() < problem.steps())
      throw Interrupted();
  };
  trajectory::Trajectory motion(stepper, problem.initial, control_problem.storage, true);
  const control::ControlForce force(control_problem.controls, reduced.control());
  run(motion, force, [&](const trajectory::Frame& frame) {
    if (objective)
      objective->observe(frame.step.k, frame.after.y());
  });
  const control::ObjectiveDuals along(control_problem.objective, motion);
  const step::DualAtStep derivative(problem.space, along);
  std::optional<EnrichedObjective::Derivative> enriched_along;
  std::optional<step::DualAtStep> enriched_derivative;
  if (objective)
    enriched_derivative.emplace(body->space(), enriched_along.emplace(*objective, motion));
  petsc::Vector by_nodes;
  if (by_cells && body)
    by_nodes = body->space().vector();
  const auto weigh = [&](const trajectory::Trajectory& trajectory, const control::Control& u) {
    const control::ControlForce acting(control_problem.controls, u);
    const step::ForceAtStep load = problem.load(&acting);
    std::optional<EnrichedLoads::Force> enriched_force;
    std::optional<step::ForceAtStep> enriched_load;
    if (loads)
      enriched_load = loads->with(enriched_force.emplace(*loads, u));
    return adjoint::weighted_residual(stepper, body ? &*body : nullptr,
                                      {trajectory, load, derivative,
                                       enriched_load ? &*enriched_load : nullptr,
                                       enriched_derivative ? &*enriched_derivative : nullptr},
                                      by_nodes);
  };
  adjoint::ErrorParts parts = weigh(motion, reduced.control());
  if (control_problem.reference) {
    const control::ControlForce u(control_problem.controls, *control_problem.reference);
    const trajectory::StateStoreFactory storage = problem::state_stores(problem);
    trajectory::Trajectory desired(stepper, problem.initial, storage, true);
    run(desired, u, {});
    if (by_nodes)
      check(VecScale(by_nodes, -1)); // like the parts: the motion's less the desired one's
    subtract(weigh(desired, *control_problem.reference), parts);
  }
  if (objective) {
    parts.initial += objective->parts.initial;
    parts.desired = objective->parts.desired;
  }
  if (by_nodes)
    *by_cells = body->by_cells(by_nodes);
  parts.time += control_problem.objective.quadrature_error(reduced.squared_distances(), reduced.control());
  return parts;
}

EstimatedValue estimated_value(const control::ControlSpace& from, const control::Control& u,
                               const problem::Problem& problem, problem::ControlProblem& there) {
  const control::Interpolation interpolate(from, there.controls);
  const double J = there.reduced.value(interpolate(u));
  there.reduced.accept();
  return {J, estimate_error(problem, there)};
}

double error_by_coarser_mesh(const EstimatedValue& fine, const EstimatedValue& coarse, double ratio) {
  const double change = fine.J - coarse.J, estimated = fine.error.sum(),
               unexplained = change + estimated - coarse.error.sum();
  return std::min(std::abs(change) / (ratio - 1), std::abs(estimated) + std::abs(unexplained) / (ratio - 1));
}

Verified verify_with_half_steps(const problem::Problem& problem,
                                const problem::ControlProblem& control_problem) {
  const control::ReducedProblem& reduced = control_problem.reduced;
  Verified found;
  {
    diagnostics::StepWarnings watch(problem.stepper, problem.scene, problem.scene_loads());
    const int done = trajectory::integrate(problem.stepper, problem.grid, problem.initial, reduced.load(),
                                           [&](const trajectory::Frame& frame) { watch.observe(frame); });
    if (done < problem.steps())
      throw Interrupted();
    found.warnings = watch.warnings();
  }
  const scene::Scene halved = on_rung(problem.scene, own_rung(problem.scene).with_steps(0.5));
  const Console silent(false, false);
  Timers timers;
  problem::Problem finer(problem.discretisation, halved, problem::search_needs(halved), timers);
  if (!finer.grid.complete())
    problem::choose_steps(finer, control_problem.controls, reduced.control(), silent);
  problem::ControlProblem there(finer, silent);
  const control::Interpolation interpolate(control_problem.controls, there.controls);
  found.change = std::abs(there.reduced.value(interpolate(reduced.control())) - reduced.value().total());
  return found;
}

} // namespace signorini::accuracy
