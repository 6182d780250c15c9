// SPDX-License-Identifier: GPL-3.0-or-later
#include "adjoint/parameter_sweep.h"
#include "base/counters.h"
#include "base/error.h"
#include "forward/extrapolation.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::adjoint {
using petsc::check;

namespace {

long& sweeps = count("adjoint sweeps");

/// A backward sweep. The dual of v_k is M ω_k + e_k: what J depends on velocities by enters through e_k, so
/// that no system with M is solved.
class Sweep {
public:
  Sweep(const forward::Stepper& stepper, forward::Stepper::Workspace& work, const forward::Trajectory& motion,
        const MotionDuals& duals, forward::ParameterRates& rates,
        const std::function<void(int k, Vec p)>& visit)
      : stepper_(stepper), work_(work), motion_(motion), grid_(motion.grid()), duals_(duals), rates_(rates),
        visit_(visit), extrapolation_(stepper), state_(stepper.adjoint_state()), from_(stepper.state()),
        to_(stepper.state()), normal_(stepper.rows()), zero_(normal_.size()), c_(normal_.size()),
        mu_(normal_.size()), zeta_(normal_.size()), e_(duals.velocities()), e_next_(e_.size()),
        factors_(e_.size()), gradient_(rates.count()) {
    for (petsc::Vector* one : {&s_, &w_, &force_})
      *one = stepper.space().vector();
  }

  std::vector<double> run() {
    ++sweeps;
    const int steps = motion_.steps();
    from_.copy(motion_.at(steps));
    for (int k = steps; k >= 1; --k) {
      collect(k);
      try {
        step(k);
      } catch (const SolverFailure& failure) {
        throw SolverFailure(fmt::format("adjoint step {}: {}", k, failure.what()));
      }
      if (visit_)
        visit_(k, state_.p);
      std::swap(from_, to_); // not before, as rates_ refers to them in step()
      from_.copy(motion_.at(k - 1));
      add_step(k);
      state_.advance();
    }
    collect(0);
    start();
    return std::move(gradient_);
  }

private:
  [[nodiscard]] const contact::ContactLinearisation& contact(int k) const {
    return motion_.contact()[static_cast<std::size_t>(k)];
  }
  [[nodiscard]] forward::StepContact made(int k) const { return {grid_.scheme(k), contact(k)}; }
  /// Whether the predictor of step k is projected.
  [[nodiscard]] bool projected(int k) const {
    return stepper_.predictor() && k <= motion_.steps() && !contact(k).predictor.empty();
  }

  /// e_k from e_{k+1}, and w_ = ∂J/∂y_k with what velocities add to it.
  void collect(int k) {
    check(VecZeroEntries(w_));
    duals_.add_displacement(k, w_);
    if (e_.empty())
      return;
    std::swap(e_, e_next_);
    duals_.velocity_factors(k, e_);
    const bool moved = projected(k + 1), last = k == motion_.steps();
    const double rate = k > 0 ? grid_.scheme(k).rate() : 0,
                 later = last || moved ? 0 : grid_.scheme(k + 1).rate();
    for (std::size_t i = 0; i < e_.size(); ++i) {
      e_[i] += moved ? e_next_[i] : -e_next_[i];
      factors_[i] = rate * e_[i] - later * e_next_[i];
    }
    duals_.add_velocities(factors_, w_);
  }

  /// The force −rate() e_{k+1} that the transposed projection sees beside M s_{k+1}.
  const forward::Predictor::Data& projection(int k) {
    projection_ = {nullptr, zero_, zeta_};
    if (e_.empty())
      return projection_;
    const double rate = grid_.scheme(k + 1).rate();
    for (std::size_t i = 0; i < e_.size(); ++i)
      factors_[i] = -rate * e_next_[i];
    check(VecZeroEntries(force_));
    duals_.add_velocities(factors_, force_);
    projection_.force = force_;
    return projection_;
  }

  void step(int k) {
    if (duals_.of_forces())
      duals_.forces(k, normal_);
    prepare(k);
    extrapolation_.guess(grid_.time(k), state_.p);
    const Vec jump = stepper_.adjoint_step({made(k),
                                            k < motion_.steps() ? std::optional(made(k + 1)) : std::nullopt,
                                            {{.vector = w_}},
                                            state_,
                                            normal_,
                                            mu_,
                                            projected(k + 1) ? &projection(k) : nullptr},
                                           work_);
    extrapolation_.remember(grid_.time(k), state_.p);
    if (jump)
      add_predictor(jump, contact(k + 1).predictor);
  }

  /// s_{k+1}, of which the transposed projection of step k + 1 is made.
  void prepare(int k) {
    if (projected(k + 1))
      check(VecWAXPY(s_, -grid_.scheme(k + 1).rate(), state_.omega, state_.p_next));
  }

  /// Of the step that rates_ refer to: z·r_j + ζ·e_j, z = s + jump.
  void add_predictor(Vec jump, const contact::ActiveSet& set) {
    check(VecAXPY(s_, 1, jump));
    for (std::size_t j = 0; j < gradient_.size(); ++j) {
      if (!rates_.predictor(j, force_, c_))
        continue;
      gradient_[j] += petsc::dot(s_, force_);
      for (int i : set)
        gradient_[j] += zeta_[static_cast<std::size_t>(i)] * c_[static_cast<std::size_t>(i)];
    }
  }

  void add_step(int k) {
    rates_.set({grid_.step(k), from_, to_, contact(k)});
    for (std::size_t j = 0; j < gradient_.size(); ++j) {
      gradient_[j] += rates_.pairing(j, state_.p);
      if (rates_.constraint(j, c_))
        for (int i : contact(k).active)
          gradient_[j] += mu_[static_cast<std::size_t>(i)] * c_[static_cast<std::size_t>(i)];
      if (const contact::ConstraintRows* rows = rates_.rows(j); rows && duals_.of_forces())
        gradient_[j] += duals_.by_rows(k, contact(k), *rows);
    }
  }

  /// The duals of the initial state, of which state_.p_next, state_.omega and e_next_ are now those of
  /// step 1.
  void start() {
    const petsc::Vector dual = stepper_.space().vector();
    prepare(0);
    const Vec jump = stepper_.adjoint_start(
        {made(0), made(1), {{.vector = w_}}, state_, {}, {}, projected(1) ? &projection(0) : nullptr}, work_);
    if (jump)
      add_predictor(jump, contact(1).predictor);
    check(MatMult(stepper_.M(), state_.omega, dual));
    duals_.add_velocities(e_, dual);
    for (std::size_t j = 0; j < gradient_.size(); ++j) {
      if (const Vec v = rates_.velocity(j))
        gradient_[j] += petsc::dot(dual, v);
      if (const Vec y = rates_.displacement(j))
        gradient_[j] += petsc::dot(state_.p, y);
    }
  }

  const forward::Stepper& stepper_;
  forward::Stepper::Workspace& work_;
  const forward::Trajectory& motion_;
  forward::TimeGrid grid_;
  const MotionDuals& duals_;
  forward::ParameterRates& rates_;
  const std::function<void(int k, Vec p)>& visit_;
  forward::Extrapolation extrapolation_;
  forward::AdjointState state_;
  forward::State from_, to_; ///< of the step
  petsc::Vector s_, w_, force_;
  std::vector<double> normal_, zero_, c_;    ///< ∂J/∂λ_k; zeros; of one unknown (of rows)
  std::vector<double> mu_, zeta_;            ///< multipliers of the step, of the projection (of rows)
  std::vector<double> e_, e_next_, factors_; ///< of the functionals of velocities
  forward::Predictor::Data projection_;
  std::vector<double> gradient_;
};

} // namespace

std::vector<double> parameter_gradient(const forward::Stepper& stepper, forward::Stepper::Workspace& work,
                                       const forward::Trajectory& motion, const MotionDuals& duals,
                                       forward::ParameterRates& rates,
                                       const std::function<void(int k, Vec p)>& visit) {
  return Sweep(stepper, work, motion, duals, rates, visit).run();
}

} // namespace signorini::adjoint
