#include "estimate.h"
#include "base/error.h"

namespace signorini {
using petsc::check;

namespace {

/// The loads of a scene and its controls in functions of degree 2.
class EnrichedLoads {
public:
  EnrichedLoads(const adjoint::EnrichedBody& body, const Problem& problem, bool cellwise)
      : body_(body), controls_(body.space(), body.operators(), problem.stepper.scheme(), problem.steps(), *problem.scene.control),
        cellwise_(cellwise) {
    if (problem.scene.load)
      load_.emplace(body.space(), *problem.scene.load, problem.stepper.scheme());
  }

  /// Valid as long as this object and the control that it makes live.
  forward::Load load(const control::Control& enriched) const {
    return load_ ? load_->load() + controls_.load(enriched) : controls_.load(enriched);
  }

  control::Control enrich(const control::Control& u) const {
    control::Control fine = controls_.zero();
    for (int k = 1; k <= u.count(); ++k)
      if (cellwise_)
        check(VecCopy(u.at(k), fine.at(k)));
      else
        check(MatMult(body_.enrichment().embed, u.at(k), fine.at(k)));
    return fine;
  }

private:
  const adjoint::EnrichedBody& body_;
  control::ControlSpace controls_;
  bool cellwise_;
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
    loads.emplace(*body, problem, control_problem.controls.cellwise());
  }
  const forward::Load derivative = control_problem.objective.derivative(reduced.trajectory());
  const auto weigh = [&](const forward::Trajectory& trajectory, const control::Control& u, const forward::Load& dual) {
    std::optional<control::Control> fine;
    if (loads)
      fine = loads->enrich(u);
    return adjoint::weighted_residual(stepper, body ? &*body : nullptr, trajectory,
                                      problem.load() + control_problem.controls.load(u),
                                      loads ? loads->load(*fine) : forward::Load{}, dual);
  };
  adjoint::ErrorParts parts = weigh(reduced.trajectory(), reduced.control(), derivative);
  if (control_problem.reference) {
    const control::Control& u = *control_problem.reference;
    forward::Trajectory desired(stepper, problem.steps());
    forward::simulate(stepper, problem.initial, problem.load() + control_problem.controls.load(u), desired);
    if (desired.steps < problem.steps())
      throw Interrupted();
    const adjoint::ErrorParts other = weigh(desired, u, derivative);
    parts.time -= other.time;
    if (parts.space)
      *parts.space -= *other.space;
  }
  parts.time += control_problem.objective.quadrature_error(reduced.trajectory(), reduced.control());
  return parts;
}

} // namespace signorini
