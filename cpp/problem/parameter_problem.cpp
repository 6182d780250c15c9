// SPDX-License-Identifier: GPL-3.0-or-later
#include "problem/parameter_problem.h"
#include "io/fit_tables.h"

namespace signorini::problem {
namespace {

/// Owns the objects to which a control::Model refers.
struct Parts {
  Parts(const ParameterProblem& of, std::span<const double> x, std::size_t columns, trajectory::Stops stops,
        Timers& timers)
      : theta(of.misfit.values(x)), scene(scene::with_values(of.scene, theta)),
        problem(of.discretisation, scene, of.needs(), timers, stops),
        measurements(problem.stepper, problem.grid, scene, of.misfit.times(), columns),
        rates(problem.stepper, of.scene, theta),
        storage(problem.stepper, problem.grid, scene.trajectory, 1, timers) {
    if (!of.seeks_control())
      given.emplace(problem);
  }

  std::vector<double> theta;
  scene::Scene scene;
  Problem problem;
  std::optional<GivenControl> given; ///< the scene's control; absent if a control is sought
  control::Measurements measurements;
  step::ParameterRates rates;
  trajectory::StateStoreFactory storage;
};

} // namespace

ParameterProblem::ParameterProblem(std::shared_ptr<const SpaceDiscretisation> shared, const scene::Scene& s,
                                   Timers& timers, const ControlProblem* control)
    : scene(s), discretisation(std::move(shared)), misfit(s, io::read_data(discretisation->space.comm(), s)),
      reduced([this](std::span<const double> x, std::size_t columns,
                     trajectory::Stops stops) { return model(x, columns, stops); },
              misfit, control ? &control->controls : nullptr, control ? &control->objective : nullptr,
              timers),
      timers_(timers), seeks_control_(control) {}

step::Stepper::Needs ParameterProblem::needs() const {
  step::Stepper::Needs needs = fit_needs(scene);
  if (iterative_) { // as decided for the first values
    needs.passes = 0;
    needs.iterative = *iterative_ && scene.solver.linear == scene::LinearMethod::automatic;
  }
  return needs;
}

control::Model ParameterProblem::model(std::span<const double> x, std::size_t columns,
                                       trajectory::Stops stops) {
  const auto parts = std::make_shared<Parts>(*this, x, columns, stops, timers_);
  const Problem& problem = parts->problem;
  if (!iterative_)
    iterative_ = problem.stepper.solver().iterates();
  return {.stepper = &problem.stepper,
          .initial = &problem.initial,
          .storage = &parts->storage,
          .load = problem.scene_loads(),
          .given = parts->given ? parts->given->control_force() : nullptr,
          .measurements = &parts->measurements,
          .rates = &parts->rates,
          .parts = parts};
}

} // namespace signorini::problem
