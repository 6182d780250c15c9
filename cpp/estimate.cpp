#include "estimate.h"
#include "base/error.h"

namespace signorini {
using petsc::check;

namespace {

/// The loads of a scene and its controls in functions of degree 2.
class EnrichedLoads {
public:
  EnrichedLoads(const adjoint::EnrichedBody& body, const Problem& problem, const control::ControlSpace& controls)
      : body_(body), coarse_(controls),
        controls_(body.space(), body.operators(), problem.stepper.scheme(), problem.steps(), *problem.scene.control),
        coarse_field_(controls.field()), field_(controls_.field()), values_(controls_.value()) {
    if (problem.scene.load)
      load_.emplace(body.space(), *problem.scene.load, problem.stepper.scheme());
  }

  /// With a control; valid as long as this object and the control live.
  forward::Load load(const control::Control& u) const {
    const forward::Load control = controls_.load([this, &u](int k) { return enriched(u.at(k)); });
    return load_ ? load_->load() + control : control;
  }

private:
  Vec enriched(Vec u) const {
    if (controls_.cellwise())
      return u;
    coarse_.extend(u, coarse_field_);
    check(MatMult(body_.enrichment().embed, coarse_field_, field_));
    controls_.restrict(field_, values_);
    return values_;
  }

  const adjoint::EnrichedBody& body_;
  const control::ControlSpace& coarse_;
  control::ControlSpace controls_;
  petsc::Vector coarse_field_, field_, values_;
  std::optional<forward::SceneLoad> load_;
};

} // namespace

adjoint::ErrorParts estimate_error(const Problem& problem, const ControlProblem& control_problem) {
  const forward::Stepper& stepper = problem.stepper;
  const control::ReducedProblem& reduced = control_problem.reduced;
  std::optional<adjoint::EnrichedBody> body;
  std::optional<EnrichedLoads> loads;
  if (problem.space.degree() == 1) {
    body.emplace(problem.space, stepper.constraints(), problem.scene);
    loads.emplace(*body, problem, control_problem.controls);
  }
  // Motions of their own, since velocities are wanted; that of the current control is looked at beside the other one.
  const auto run = [&](forward::Trajectory& trajectory, const control::Control& u) {
    trajectory.run(problem.load() + control_problem.controls.load(u));
    if (trajectory.steps() < problem.steps())
      throw Interrupted();
  };
  forward::Trajectory motion(stepper, problem.initial, problem.steps(), control_problem.storage, true);
  run(motion, reduced.control());
  const forward::Load derivative = control_problem.objective.derivative([&](int k) { return motion.y(k); });
  const auto weigh = [&](const forward::Trajectory& trajectory, const control::Control& u) {
    return adjoint::weighted_residual(stepper, body ? &*body : nullptr, trajectory,
                                      problem.load() + control_problem.controls.load(u),
                                      loads ? loads->load(u) : forward::Load{}, derivative);
  };
  adjoint::ErrorParts parts = weigh(motion, reduced.control());
  if (control_problem.reference) {
    const control::Control& u = *control_problem.reference;
    const forward::Storage storage(stepper, problem.scene.trajectory, problem.steps(), 0.5, problem.timers);
    forward::Trajectory desired(stepper, problem.initial, problem.steps(), storage, true);
    run(desired, u);
    const adjoint::ErrorParts other = weigh(desired, u);
    parts.time -= other.time;
    if (parts.space)
      *parts.space -= *other.space;
  }
  parts.time += control_problem.objective.quadrature_error(reduced.squared_distances(), reduced.control());
  return parts;
}

} // namespace signorini
