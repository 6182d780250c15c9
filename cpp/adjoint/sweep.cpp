// SPDX-License-Identifier: GPL-3.0-or-later
#include "adjoint/sweep.h"
#include "base/error.h"
#include "base/timers.h"
#include "trajectory/time_integrator.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::adjoint {
using petsc::check;

namespace {

long& sweeps = count("adjoint sweeps");

/// Data of a motion for a backward sweep.
struct Motion {
  const step::Stepper& stepper;
  const step::TimeGrid& grid;
  const std::vector<contact::ContactLinearisation>& contact;

  [[nodiscard]] int steps() const { return static_cast<int>(contact.size()) - 1; }
  [[nodiscard]] const contact::ContactLinearisation& at(int k) const { return contact[k]; }
  [[nodiscard]] step::StepContact made(int k) const { return {grid.scheme(k), at(k)}; }
  [[nodiscard]] std::optional<step::StepContact> after(int k) const {
    return k < steps() ? std::optional(made(k + 1)) : std::nullopt;
  }
  /// Returns whether step k moved its predictor by the projection.
  [[nodiscard]] bool projected(int k) const {
    return stepper.predictor() && k <= steps() && !at(k).predictor.empty();
  }
};

/// Terms of the transposed steps due to derivatives of J by velocities and forces. The dual of v_k is M ω_k +
/// e_k. The derivatives of J by velocities enter e_k, so that no system with M is solved.
class FunctionalTerms {
public:
  FunctionalTerms(const Motion& motion, const VelocityForceDuals& duals)
      : motion_(motion), duals_(duals), normal_(motion.stepper.rows()), zero_(normal_.size()),
        mu_(normal_.size()), law_(normal_.size()), zeta_(normal_.size()), e_(duals.velocities()),
        e_next_(e_.size()), factors_(e_.size()) {
    if (!e_.empty())
      force_ = motion.stepper.space().vector();
    if (motion.stepper.velocity_extrapolation())
      functional_ = motion.stepper.space().vector();
  }

  /// Computes e_k from e_{k+1}, and adds the contribution of velocities to ∂J/∂y_k in `dual`.
  void add_to(int k, const step::StateDual& dual) {
    if (duals_.of_forces() && k > 0)
      duals_.forces(k, normal_);
    if (e_.empty())
      return;
    std::swap(e_, e_next_);
    duals_.velocity_factors(k, e_);
    const bool moved = motion_.projected(k + 1), last = k == motion_.steps();
    const double rate = k > 0 ? motion_.grid.scheme(k).rate() : 0,
                 later = last || moved ? 0 : motion_.grid.scheme(k + 1).rate();
    for (std::size_t i = 0; i < e_.size(); ++i) {
      e_[i] += moved ? e_next_[i] : -e_next_[i];
      factors_[i] = rate * e_[i] - later * e_next_[i];
    }
    add_velocities(factors_, dual.vector);
  }

  /// Returns the data of the transposed projection of step k + 1, which acts on M s_{k+1} and the force
  /// −rate() e_{k+1}. Null if the predictor of step k + 1 is not projected.
  const step::PredictorProjection::Data* projection(int k) {
    if (!motion_.projected(k + 1))
      return nullptr;
    projection_ = {nullptr, zero_, zeta_};
    if (e_.empty())
      return &projection_;
    const double rate = motion_.grid.scheme(k + 1).rate();
    for (std::size_t i = 0; i < e_.size(); ++i)
      factors_[i] = -rate * e_next_[i];
    check(VecZeroEntries(force_));
    add_velocities(factors_, force_);
    projection_.force = force_;
    return &projection_;
  }

  /// Returns transposed step k with the terms of velocities and forces.
  step::AdjointStep step(int k, step::StateDual dual, step::AdjointState& state) {
    add_to(k, dual);
    if (k == 0)
      return {motion_.made(0), motion_.made(1), dual, state, {}, {}, {}, projection(0)};
    return {motion_.made(k), motion_.after(k), dual, state, normal_, mu_, law_, projection(k)};
  }

  [[nodiscard]] const VelocityForceDuals& duals() const { return duals_; }
  /// Returns the multipliers μ of the last transposed step (rows).
  [[nodiscard]] std::span<const double> mu() const { return mu_; }
  /// Returns minus the derivatives by the right-hand sides of the laws in the last transposed step (rows).
  [[nodiscard]] std::span<const double> law() const { return law_; }
  /// Returns the multipliers ζ of the last transposed projection (rows).
  [[nodiscard]] std::span<const double> zeta() const { return zeta_; }
  /// Adds e_0, the dual of the initial velocities without M ω_0, to `dual`.
  void add_start(Vec dual) const { add_velocities(e_, dual); }

private:
  /// Adds Σ_i factors_i Eᵀφ_i to `sum`, with the extrapolation E of velocities, or the identity.
  void add_velocities(std::span<const double> factors, Vec sum) const {
    const Mat E = motion_.stepper.velocity_extrapolation();
    if (!E)
      return duals_.add_velocities(factors, sum);
    check(VecZeroEntries(functional_));
    duals_.add_velocities(factors, functional_);
    check(MatMultTransposeAdd(E, functional_, sum, sum));
  }

  const Motion& motion_;
  const VelocityForceDuals& duals_;
  std::vector<double> normal_, zero_, mu_, law_, zeta_; ///< normal_: ∂J/∂λ_k
  std::vector<double> e_, e_next_, factors_; ///< coefficients of e_k and e_{k+1} in the functionals
  petsc::Vector force_{}, functional_{};
  step::PredictorProjection::Data projection_;
};

/// Sums up dJ/dθ along a backward sweep.
class ParameterGradient {
public:
  ParameterGradient(const Motion& motion, const FunctionalTerms& terms, const trajectory::Trajectory& states,
                    step::ParameterRates& rates)
      : motion_(motion), terms_(terms), states_(states), rates_(rates), from_(motion.stepper.state()),
        to_(motion.stepper.state()), s_(motion.stepper.space().vector()), r_(motion.stepper.space().vector()),
        c_(motion.stepper.rows()), gradient_(rates.count()) {
    from_.copy(states_.at(motion.steps()));
  }

  /// Computes s_{k+1}, the argument of the projection of step k + 1, before the transpose of step k.
  void before(int k, const step::AdjointState& state) {
    if (motion_.projected(k + 1))
      check(VecWAXPY(s_, -motion_.grid.scheme(k + 1).rate(), state.omega, state.p_next));
  }

  /// Adds the part of the projected predictor of step k + 1, z·r_j + ζ·e_j with z = s + jump. rates_ must
  /// refer to step k + 1.
  void add_predictor(int k, Vec jump) {
    if (!jump)
      return;
    check(VecAXPY(s_, 1, jump));
    for (std::size_t j = 0; j < gradient_.size(); ++j) {
      if (!rates_.predictor(j, r_, c_))
        continue;
      gradient_[j] += petsc::dot(s_, r_);
      for (int i : motion_.at(k + 1).predictor)
        gradient_[j] += terms_.zeta()[i] * c_[i];
    }
  }

  void add_step(int k, const step::AdjointState& adjoint) {
    std::swap(from_, to_); // not before, as rates_ refers to them in add_predictor()
    from_.copy(states_.at(k - 1));
    rates_.set({motion_.grid.step(k), from_, to_, motion_.at(k)});
    for (std::size_t j = 0; j < gradient_.size(); ++j) {
      gradient_[j] += rates_.pairing(j, adjoint.p, adjoint.z);
      if (rates_.constraint(j, c_)) {
        const contact::ConstraintRows& rows = motion_.stepper.pairs()->rows();
        for (const int i : motion_.at(k).active)
          for (std::size_t row = 0; row < rows.size(i); ++row)
            gradient_[j] += terms_.mu()[rows.row(i, row)] * c_[rows.row(i, row)];
      }
      if (rates_.law(j, c_))
        for (std::size_t i = 0; i < c_.size(); ++i)
          gradient_[j] -= terms_.law()[i] * c_[i];
      if (const contact::ConstraintRows* rows = rates_.rows(j); rows && terms_.duals().of_forces())
        gradient_[j] += terms_.duals().by_rows(k, motion_.at(k), *rows);
    }
  }

  /// Adds the part of the initial state, with the duals in `state`, and returns the gradient.
  std::vector<double> finish(const step::AdjointState& state) {
    check(MatMult(motion_.stepper.M(), state.omega, r_));
    terms_.add_start(r_);
    for (std::size_t j = 0; j < gradient_.size(); ++j) {
      if (const Vec v = rates_.velocity(j))
        gradient_[j] += petsc::dot(r_, v);
      if (const Vec y = rates_.displacement(j))
        gradient_[j] += petsc::dot(state.p, y);
    }
    return std::move(gradient_);
  }

private:
  const Motion& motion_;
  const FunctionalTerms& terms_;
  const trajectory::Trajectory& states_;
  step::ParameterRates& rates_;
  step::State from_, to_; ///< states before and after the step
  petsc::Vector s_, r_;
  std::vector<double> c_; ///< constraint rates of one unknown (rows)
  std::vector<double> gradient_;
};

/// Makes the transposed steps N … 1. `step(k, state)` returns a step's data; `made(k, state, jump)` is called
/// after the step.
template <class Step, class Made>
step::AdjointState backward(const Motion& motion, step::Stepper::Workspace& work, Step&& step, Made&& made) {
  ++sweeps;
  step::AdjointState state = motion.stepper.adjoint_state();
  trajectory::Extrapolation extrapolation(motion.stepper);
  for (int k = motion.steps(); k >= 1; --k) {
    Vec jump = nullptr;
    try {
      extrapolation.guess(motion.grid.time(k), state.p);
      jump = motion.stepper.adjoint_step(step(k, state), work);
      extrapolation.remember(motion.grid.time(k), state.p);
    } catch (const SolverFailure& failure) {
      throw SolverFailure(fmt::format("adjoint step {}: {}", k, failure.what()));
    }
    made(k, state, jump);
    state.advance();
  }
  return state;
}

} // namespace

void sweep(const step::Stepper& stepper, step::Stepper::Workspace& work, const step::TimeGrid& grid,
           const std::vector<contact::ContactLinearisation>& contact,
           const step::DualAtStep& by_displacements, const AdjointObserver& visit) {
  const Motion motion{stepper, grid, contact};
  (void)backward(
      motion, work,
      [&](int k, step::AdjointState& state) {
        return step::AdjointStep{motion.made(k), motion.after(k), by_displacements.at(grid.step(k)), state};
      },
      [&](int k, const step::AdjointState& state, Vec) { visit(k, state.p); });
}

std::vector<double> sweep(const step::Stepper& stepper, step::Stepper::Workspace& work,
                          const trajectory::Trajectory& motion_made, const step::DualAtStep& by_displacements,
                          const VelocityForceDuals& duals, step::ParameterRates& rates,
                          const AdjointObserver& visit) {
  const Motion motion{stepper, motion_made.grid(), motion_made.contact()};
  FunctionalTerms terms(motion, duals);
  ParameterGradient gradient(motion, terms, motion_made, rates);
  const auto step = [&](int k, step::AdjointState& state) {
    gradient.before(k, state);
    return terms.step(k, by_displacements.at(motion.grid.step(k)), state);
  };
  step::AdjointState state =
      backward(motion, work, step, [&](int k, const step::AdjointState& made, Vec jump) {
        gradient.add_predictor(k, jump);
        if (visit)
          visit(k, made.p);
        gradient.add_step(k, made);
      });
  gradient.add_predictor(0, stepper.adjoint_start(step(0, state), work));
  return gradient.finish(state);
}

} // namespace signorini::adjoint
