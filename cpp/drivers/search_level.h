// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "control/interpolation.h"
#include "drivers/coarse_start.h"
#include <memory>

namespace signorini::drivers {

/// Control problem of a scene on one mesh and time grid, and a search for its optimum, which can start from
/// the search on another mesh. Method: Lbfgs, NewtonCg or ProjectedGradient. All members are collective.
template <template <optimize::TwiceDifferentiable> class Method>
class SearchLevel {
public:
  using Unknowns = optimize::Dimensionless<control::ReducedProblem>;
  using State = optimize::State<Unknowns, Method<Unknowns>>;
  using Inheritance = typename SearchStart<Method>::Inheritance;

  /// Sets up the problem. If step lengths vary, a preliminary motion chooses them. Its control is the one
  /// found by `last`. If `last` is null or has no result, it is the control that the scene gives, else the
  /// reference control. Throws UserError, SolverFailure, Interrupted.
  SearchLevel(MPI_Comm comm, scene::Scene scene, const mesh::Meshing& meshing, const SearchLevel* last,
              step::Stepper::Needs needs = {.derivatives = true})
      : scene_(std::move(scene)),
        problem_(std::make_shared<const problem::SpaceDiscretisation>(comm, scene_, timers_, meshing), scene_,
                 needs, timers_),
        control_problem_(with_steps(problem_, last), Console(false, false)) {}

  [[nodiscard]] const problem::Problem& problem() const { return problem_; }
  [[nodiscard]] control::Control first_guess() const { return control_problem_.first_guess(scene_); }
  [[nodiscard]] problem::ControlProblem& control_problem() { return control_problem_; }

  /// Searches from `start`. `report`: as for optimize::minimize(); if `report` has a member certified(), this
  /// receives the certificate of a kink. Throws SolverFailure, Interrupted.
  template <class Report>
  void search(SearchStart<Method> start, const optimize::Options& options, Report&& report) {
    LastState<std::remove_reference_t<Report>> last{report};
    const auto end = optimize::minimize<Method>(control_problem_.reduced, std::move(start.guess), options,
                                                report, last, std::move(start.inherited));
    if (end.stop == optimize::Stop::interrupted)
      throw Interrupted();
    last_ = std::move(last.state);
    stop_ = end.stop;
    first_norm_ = end.first_norm;
  }

  /// Start of a search for the problem `finer`: the result and method state of this search, interpolated to
  /// that problem's mesh and steps. Call after search().
  [[nodiscard]] SearchStart<Method> start_for(problem::ControlProblem& finer,
                                              const optimize::Options& options) const {
    const control::Interpolation interpolate(control_problem_.controls, finer.controls);
    Unknowns unknowns(finer.reduced);
    unknowns.measure_in(last_->units);
    Inheritance inherited{last_->units, last_->first_norm, Method<Unknowns>(options)};
    inherited.memory.inherit(last_->memory, unknowns, interpolate);
    return {interpolate(last_->current.u), std::move(inherited)};
  }

  /// Reason why the search stopped.
  [[nodiscard]] optimize::Stop stop() const { return stop_; }
  /// Gradient norm at the first guess.
  [[nodiscard]] double first_norm() const { return first_norm_; }
  /// Last state of the search. Call after search().
  [[nodiscard]] State& state() { return *last_; }

  /// Record of the level for run.json, without its seconds. Call after search().
  [[nodiscard]] io::CoarseLevel record() const {
    const control::ReducedProblem& reduced = control_problem_.reduced;
    return {.size = scene_.mesh.size.value_or(scene_.mesh.scale),
            .step = scene_.time.end / problem_.steps(),
            .steps = problem_.steps(),
            .free_unknowns = problem_.free_dofs(),
            .iterations = last_->iteration.number,
            .forward_sweeps = reduced.sweeps().forward,
            .adjoint_sweeps = reduced.sweeps().adjoint,
            .objective = reduced.value().total(),
            .stop_reason = optimize::name(stop_)};
  }

private:
  /// Checkpointer of optimize::minimize() that keeps the last state in memory, and passes certificates to
  /// reports that have a member certified().
  template <class Report>
  struct LastState {
    Report& report;
    std::optional<State> state{};

    static bool restore(State&) { return false; }
    static bool due(const optimize::Iteration&) { return false; }
    void store(const State& last) { state = last; }
    static void restored(double, double) {}
    static void mark() {}
    void certified(const optimize::Certificate<control::Variables>& certificate) {
      if constexpr (requires { report.certified(certificate); })
        report.certified(certificate);
    }
  };

  static const problem::Problem& with_steps(problem::Problem& problem, const SearchLevel* last) {
    const Console silent(false, false);
    if (problem.grid.complete())
      return problem;
    if (!last || !last->last_) {
      problem::choose_steps(problem, silent);
      return problem;
    }
    problem::choose_steps(problem, last->control_problem_.controls, last->last_->current.u.u, silent);
    return problem;
  }

  scene::Scene scene_;
  Timers timers_;
  problem::Problem problem_;
  problem::ControlProblem control_problem_;
  std::optional<State> last_;
  optimize::Stop stop_ = optimize::Stop::iteration_limit;
  double first_norm_ = 0;
};

} // namespace signorini::drivers
