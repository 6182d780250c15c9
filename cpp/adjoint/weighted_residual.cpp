// SPDX-License-Identifier: GPL-3.0-or-later
#include "adjoint/weighted_residual.h"
#include "adjoint/enriched_body.h"
#include "adjoint/sweep.h"
#include <algorithm>
#include <array>
#include <cmath>

namespace signorini::adjoint {
using petsc::check, petsc::dot;

namespace {

/// States of a motion at t_{k+1}, t_k and t_{k−1}, for k from N down.
class Window {
public:
  Window(const step::Stepper& stepper, const trajectory::Trajectory& trajectory)
      : later(stepper.state()), now(stepper.state()), before(stepper.state()), trajectory_(trajectory) {
    before.copy(trajectory.at(trajectory.steps()));
  }

  /// Moves from t_{k+1} to t_k.
  void move(int k) {
    std::swap(later, now);
    std::swap(now, before);
    before.copy(trajectory_.at(k - 1));
  }

  step::State later, now, before;

private:
  const trajectory::Trajectory& trajectory_;
};

/// Residual r_k of the equation of motion in functions of degree 2; see weighted_residual().
class Residual {
public:
  Residual(const EnrichedBody& body, const Window& motion, const step::ForceAtStep& load,
           const step::TimeGrid& grid)
      : body_(body), motion_(motion), load_(load), grid_(grid), coarse_(petsc::zero_like(motion.now.y())),
        fine_(body.space().vector()), sum_(body.space().vector()), product_(body.space().vector()) {}

  Vec operator()(int k) {
    const fem::Operators& operators = body_.operators();
    const double rate = 1 / grid_.length(k);
    step::assemble(load_.at(grid_.step(k)), operators, sum_);
    subtract(operators.M, rate, motion_.now.v(), -rate, motion_.before.v());
    if (operators.B)
      subtract(*operators.B, rate, motion_.now.y(), -rate, motion_.before.y());
    subtract(operators.A, 0.5, motion_.now.y(), 0.5, motion_.before.y());
    return sum_;
  }

private:
  /// Subtracts matrix (a x + b y) from sum_, the fields being written in degree 2.
  void subtract(Mat matrix, double a, Vec x, double b, Vec y) {
    petsc::combine(coarse_, a, x, b, y);
    body_.embed(coarse_, fine_);
    check(MatMult(matrix, fine_, product_));
    check(VecAXPY(sum_, -1, product_));
  }

  const EnrichedBody& body_;
  const Window& motion_;
  const step::ForceAtStep& load_;
  step::TimeGrid grid_;
  petsc::Vector coarse_, fine_, sum_, product_;
};

/// Time part of the error, summed over t_k from k = N down.
class TimePart {
public:
  TimePart(const step::Stepper& stepper, const Window& motion, const Weighted& run)
      : stepper_(stepper), motion_(motion), grid_(run.motion.grid()), steps_(run.motion.steps()),
        load_(run.load) {
    for (petsc::Vector* x : {&change_, &now_, &later_, &force_, &force_later_, &moves_, &product_})
      *x = stepper.space().vector();
  }

  /// Adds the terms of p_k; to be called for k from N down.
  void take(int k, Vec p) {
    std::swap(force_, force_later_);
    std::swap(now_, later_);
    step::assemble(load_.at(grid_.step(k)), stepper_.operators(), force_);
    check(VecAXPBY(now_, grid_.length(k) / 2, 0, p));
    if (k == steps_)
      end();
    else
      interface(k);
    if (k == 1)
      start();
  }

  [[nodiscard]] double sum() const { return sum_; }

private:
  /// Returns x·matrix·moves_ on the free dofs.
  double weighed(Vec x, Mat matrix) {
    check(MatMult(matrix, moves_, product_));
    stepper_.clamped().clear(product_);
    return dot(x, product_);
  }

  /// Adds the interval from the end T back to the middle of step N, over which π falls by half.
  void end() {
    const double tau = grid_.length(steps_);
    check(VecAXPBY(change_, -0.5, 0, now_));
    check(VecCopy(motion_.now.v(), moves_));
    sum_ -= tau * tau / 6 * weighed(change_, stepper_.operators().A);
  }

  /// Adds the interval from the middle of step k + 1 back to that of step k.
  void interface(int k) {
    const fem::Operators& body = stepper_.operators();
    const double tau = grid_.length(k), tau_later = grid_.length(k + 1), between = (tau + tau_later) / 2;
    // Means of τ²: over the time between the middles, and their difference at t_k.
    const double squared = (std::pow(tau, 3) + std::pow(tau_later, 3)) / (2 * between),
                 jump = tau * tau - tau_later * tau_later;
    check(VecWAXPY(change_, -1, now_, later_));
    petsc::combine(moves_, 0.5 / between, motion_.later.y(), -0.5 / between, motion_.before.y());
    sum_ -= squared / 6 * weighed(change_, body.A);
    if (jump != 0) // lengths change
      sum_ += jump / 12 * weighed(at_end(tau, tau_later), body.A);
    if (body.B) {
      petsc::combine(moves_, 1 / tau_later, motion_.later.y(), 1 / tau, motion_.before.y());
      check(VecAXPY(moves_, -(1 / tau + 1 / tau_later), motion_.now.y()));
      sum_ -= squared / (12 * between) * weighed(change_, *body.B);
    }
    check(VecWAXPY(moves_, -1, force_, force_later_));
    sum_ += squared / (12 * between) * dot(change_, moves_);
  }

  /// Returns π(t_k), interpolated from the middles of the steps before and after t_k.
  Vec at_end(double tau, double tau_later) {
    if (!end_)
      end_ = stepper_.space().vector();
    petsc::combine(end_, tau_later / (tau + tau_later), now_, tau / (tau + tau_later), later_);
    return end_;
  }

  /// Adds the interval from the middle of step 1 back to 0, with the π' of t_1, and the bracket at 0.
  void start() {
    const Mat A = stepper_.operators().A;
    const double tau = grid_.length(1);
    check(VecCopy(motion_.before.v(), moves_));
    if (steps_ > 1) {
      const double between = (tau + grid_.length(2)) / 2;
      sum_ -= tau / (2 * between) * tau * tau / 6 * weighed(change_, A);
    } else {
      sum_ -= tau * tau / 6 * weighed(change_, A);
    }
    sum_ -= tau * tau / 12 * weighed(now_, A);
  }

  const step::Stepper& stepper_;
  const Window& motion_;
  step::TimeGrid grid_;
  int steps_;
  const step::ForceAtStep& load_;
  double sum_ = 0;
  petsc::Vector change_, now_, later_; ///< change of π over the last interval; π_k, π_{k+1}
  petsc::Vector force_, force_later_, moves_, product_, end_;
};

/// Parts of the error from space and initial data, summed from step N down.
class SpacePart {
public:
  SpacePart(const step::Stepper& stepper, const EnrichedBody& body, const Window& motion, const Weighted& run,
            Vec by_nodes)
      : body_(body), by_nodes_(by_nodes), contact_(run.motion.contact()), grid_(run.motion.grid()),
        steps_(run.motion.steps()), duals_(stepper, grid_), bubbles_(body, *run.enriched_derivative, grid_),
        residual_(body, motion, *run.enriched_load, grid_), later_(body.space().vector()),
        dual_(body.space().vector()), product_(body.space().vector()), coarse_(stepper.space().vector()),
        mean_(body.space().vector()), last_(body.space().vector()) {
    for (petsc::Vector& x : between_)
      x = body.space().vector();
  }

  /// Adds the space terms of p_k; to be called for k from N down.
  void take(int k, Vec p) {
    const auto i = static_cast<std::size_t>(k);
    duals_.move(k, p, k < steps_ ? &contact_[i + 1] : nullptr);
    const Vec r = residual_(k);
    body_.embed(p, dual_);
    space_ += grid_.scheme(k).impulse() * dot(dual_, r);
    if (k < steps_) {
      make_room();
      // Step 1 takes β_1 at both ends, and step N β_{N−1}.
      petsc::combine(between_[0], (k == 1 ? 1 : 0.5) * grid_.length(k), r,
                     (k + 1 == steps_ ? 1 : 0.5) * grid_.length(k + 1), later_);
      if (k + 1 == steps_)
        for (int j : {1, 2})
          check(VecCopy(between_[0], between_[j]));
      else
        weigh_last();
      check(VecCopy(bubbles_.next(k, duals_, contact_[i].active), last_));
      if (k == 1) {
        make_room();
        check(VecCopy(between_[1], between_[0]));
        weigh_last();
      }
    }
    check(VecCopy(r, later_));
  }

  [[nodiscard]] double space() const { return space_; }

  /// Returns the part of initial data; to be called after take(1, p_1).
  double initial() {
    check(VecZeroEntries(coarse_));
    duals_.move(0, coarse_, &contact_[1]); // now p_later is p_1, and the velocities ω_0, ω_1
    const auto& [dy, dv] = body_.initial_error();
    const fem::Operators& operators = body_.operators();
    const step::Scheme first = grid_.scheme(1);
    double value = 0;
    if (dv)
      value += weighed(operators.M, duals_.velocity, 1, dv);
    if (!dy)
      return value;
    if (operators.B)
      value += first.tau / 2 * weighed(*operators.B, duals_.p_later, 2 / first.tau, dy);
    value -= first.stiffness() * weighed(operators.A, duals_.p_later, 2 / first.tau, dy);
    petsc::combine(coarse_, 1 / first.tau, duals_.velocity, -1 / first.tau, duals_.velocity_later);
    return value + weighed(operators.M, coarse_, 0, dy);
  }

private:
  void make_room() { std::rotate(between_.begin(), between_.end() - 1, between_.end()); }

  /// Adds the product of the last bubbles with the residuals around their time. The residuals are averaged
  /// over three times, since in contact they alternate from step to step, as forces do.
  void weigh_last() {
    petsc::combine(mean_, 0.25, between_[0], 0.5, between_[1]);
    check(VecAXPY(mean_, 0.25, between_[2]));
    space_ += dot(last_, mean_);
    if (!by_nodes_)
      return;
    check(VecPointwiseMult(product_, last_, mean_));
    check(VecAXPY(by_nodes_, 1, product_));
  }

  /// Returns error·matrix (dual + factor β). For ω the factor of β is 1, since ω = τ/2 p to leading order in
  /// τ.
  double weighed(Mat matrix, Vec dual, double factor, Vec error) {
    body_.embed(dual, dual_);
    check(VecAXPY(dual_, factor, bubbles_.last()));
    check(MatMult(matrix, dual_, product_));
    return dot(error, product_);
  }

  const EnrichedBody& body_;
  Vec by_nodes_;
  const std::vector<contact::ContactLinearisation>& contact_;
  step::TimeGrid grid_;
  int steps_;
  Duals duals_;
  DualBubbles bubbles_;
  Residual residual_;
  double space_ = 0;
  petsc::Vector later_, dual_, product_, coarse_, mean_, last_;
  /// Values of τ r around t_k, t_{k+1} and t_{k+2}, each a mean over the two steps that meet there.
  std::array<petsc::Vector, 3> between_;
};

} // namespace

ErrorParts weighted_residual(const step::Stepper& stepper, const EnrichedBody* enriched, const Weighted& run,
                             Vec by_nodes) {
  Window motion(stepper, run.motion);
  TimePart time(stepper, motion, run);
  std::optional<SpacePart> space;
  if (enriched)
    space.emplace(stepper, *enriched, motion, run, by_nodes);
  step::Stepper::Workspace work = stepper.workspace();
  sweep(stepper, work, run.motion.grid(), run.motion.contact(), run.derivative, [&](int k, Vec p) {
    motion.move(k);
    time.take(k, p);
    if (space)
      space->take(k, p);
  });
  ErrorParts parts;
  parts.time = time.sum();
  if (space) {
    parts.space = space->space();
    parts.initial = space->initial();
  }
  return parts;
}

} // namespace signorini::adjoint
