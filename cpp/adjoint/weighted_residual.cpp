#include "adjoint/weighted_residual.h"
#include "adjoint/dual_bubbles.h"
#include "adjoint/sweep.h"

namespace signorini::adjoint {
using petsc::check, petsc::dot;

namespace {

/// The states of a motion at t_{k+1}, t_k and t_{k−1}, for k from N down.
class Window {
public:
  struct Instant {
    petsc::Vector y, v;
  };

  Window(const fem::Space& space, const forward::Trajectory& trajectory) : trajectory_(trajectory) {
    for (Instant* x : {&later, &now, &before})
      *x = {space.vector(), space.vector()};
    fill(trajectory.steps(), before);
  }

  /// Moves from t_{k+1} to t_k.
  void move(int k) {
    std::swap(later, now);
    std::swap(now, before);
    fill(k - 1, before);
  }

  Instant later, now, before;

private:
  void fill(int k, const Instant& x) const {
    const forward::StateStore::View state = trajectory_.at(k);
    check(VecCopy(state.y, x.y));
    check(VecCopy(state.v, x.v));
  }

  const forward::Trajectory& trajectory_;
};

/// The residual r_k of the equation of motion in functions of degree 2; see weighted_residual().
class Residual {
public:
  Residual(const EnrichedBody& body, const Window& motion, const forward::ForceAtStep& load, double tau)
      : body_(body), motion_(motion), load_(load), tau_(tau), coarse_(petsc::zero_like(motion.now.y)),
        fine_(body.space().vector()), sum_(body.space().vector()), product_(body.space().vector()) {}

  Vec operator()(int k) {
    const fem::Operators& operators = body_.operators();
    forward::assemble(load_.at(k), operators, sum_);
    subtract(operators.M, 1 / tau_, motion_.now.v, -1 / tau_, motion_.before.v);
    if (operators.B)
      subtract(*operators.B, 1 / tau_, motion_.now.y, -1 / tau_, motion_.before.y);
    subtract(operators.A, 0.5, motion_.now.y, 0.5, motion_.before.y);
    return sum_;
  }

private:
  /// sum −= matrix (a x + b y)
  void subtract(Mat matrix, double a, Vec x, double b, Vec y) {
    check(VecAXPBYPCZ(coarse_, a, b, 0, x, y));
    body_.embed(coarse_, fine_);
    check(MatMult(matrix, fine_, product_));
    check(VecAXPY(sum_, -1, product_));
  }

  const EnrichedBody& body_;
  const Window& motion_;
  const forward::ForceAtStep& load_;
  double tau_;
  petsc::Vector coarse_, fine_, sum_, product_;
};

/// The time part, summed over t_k from k = N down.
class TimePart {
public:
  TimePart(const forward::Stepper& stepper, const Window& motion, int steps, const forward::ForceAtStep& load)
      : stepper_(stepper), motion_(motion), steps_(steps), load_(load), tau_(stepper.grid().length(1)),
        rate_(stepper.space().vector()), later_(stepper.space().vector()), force_(stepper.space().vector()),
        force_later_(stepper.space().vector()), moves_(stepper.space().vector()),
        product_(stepper.space().vector()) {}

  /// Takes p_k after p_{k+1}.
  void take(int k, Vec p) {
    std::swap(force_, force_later_);
    forward::assemble(load_.at(k), stepper_.operators(), force_);
    // π' = (p_{k+1} − p_k)/2, with p_{N+1} = 0
    check(VecAXPBYPCZ(rate_, -0.5, 0.5, 0, p, later_));
    const bool last = k == steps_;
    sum_ += (last ? 0.5 : 1) * tau_ * at_interface(last);
    if (k == 1)
      start(p);
    check(VecCopy(p, later_));
  }

  [[nodiscard]] double sum() const { return sum_; }

private:
  double weighed(Mat matrix) {
    check(MatMult(matrix, moves_, product_));
    stepper_.clamped().clear(product_);
    return dot(rate_, product_);
  }

  /// The integrand at t_k, for the trapezoidal rule.
  double at_interface(bool last) {
    const fem::Operators& body = stepper_.operators();
    double value = 0;
    if (last) {
      check(VecCopy(motion_.now.v, moves_));
      return -tau_ * tau_ / 6 * weighed(body.A);
    }
    check(VecAXPBYPCZ(moves_, 0.5 / tau_, -0.5 / tau_, 0, motion_.later.y, motion_.before.y));
    value -= tau_ * tau_ / 6 * weighed(body.A);
    if (body.B) {
      check(VecAXPBYPCZ(moves_, 1, 1, 0, motion_.later.y, motion_.before.y));
      check(VecAXPY(moves_, -2, motion_.now.y));
      value -= weighed(*body.B) / 12;
    }
    check(VecWAXPY(moves_, -1, force_, force_later_));
    return value + tau_ / 24 * dot(rate_, moves_);
  }

  /// The boundary terms at t = 0, π(0) = τ/2 p_1, and the integral's end at t = 0, with π' of t_1.
  void start(Vec p) {
    const Mat A = stepper_.operators().A;
    check(VecCopy(motion_.before.v, moves_));
    sum_ -= tau_ * tau_ / 6 * weighed(A) * tau_ / 2;
    check(MatMult(A, moves_, product_));
    sum_ -= tau_ * tau_ / 12 * tau_ / 2 * dot(p, product_);
    if (steps_ > 1) {
      check(VecWAXPY(moves_, -1, force_, force_later_));
      sum_ -= tau_ / 24 * tau_ / 2 * dot(p, moves_);
    }
  }

  const forward::Stepper& stepper_;
  const Window& motion_;
  int steps_;
  const forward::ForceAtStep& load_;
  double tau_, sum_ = 0;
  petsc::Vector rate_, later_, force_, force_later_, moves_, product_;
};

/// The parts of space and initial data, summed from step N down.
class SpacePart {
public:
  SpacePart(const forward::Stepper& stepper, const EnrichedBody& body, const Window& motion,
            const Weighted& run)
      : body_(body), contact_(run.motion.contact()), scheme_(stepper.grid().scheme(1)),
        steps_(run.motion.steps()), duals_(stepper), bubbles_(body, *run.enriched_derivative, scheme_),
        residual_(body, motion, *run.enriched_load, scheme_.tau), later_(body.space().vector()),
        dual_(body.space().vector()), product_(body.space().vector()), coarse_(stepper.space().vector()) {}

  /// Takes p_k after p_{k+1}.
  void take(int k, Vec p) {
    const auto i = static_cast<std::size_t>(k);
    duals_.move(k, p, k < steps_ ? &contact_[i + 1] : nullptr);
    const Vec r = residual_(k);
    body_.embed(p, dual_);
    space_ += scheme_.impulse() * dot(dual_, r);
    if (k < steps_) {
      // b_k lies between steps k and k + 1: p_k⁺ takes the mean of b_{k−1} and b_k, and p_1⁺ and p_N⁺ the
      // only one.
      const Vec b = bubbles_.next(k, duals_, contact_[i].active);
      const double now = k == 1 ? 1 : 0.5, before = k + 1 == steps_ ? 1 : 0.5;
      space_ += scheme_.impulse() * (now * dot(b, r) + before * dot(b, later_));
    }
    check(VecCopy(r, later_));
  }

  [[nodiscard]] double space() const { return space_; }

  /// The part of initial data; to be called after take(1, p_1).
  double initial() {
    check(VecZeroEntries(coarse_));
    duals_.move(0, coarse_, &contact_[1]); // now p_later is p_1, and the velocities ω_0, ω_1
    const auto& [dy, dv] = body_.initial_error();
    const fem::Operators& operators = body_.operators();
    double value = 0;
    if (dv)
      value += weighed(operators.M, duals_.velocity, scheme_.tau / 2, dv);
    if (!dy)
      return value;
    if (operators.B)
      value += scheme_.tau / 2 * weighed(*operators.B, duals_.p_later, 1, dy);
    value -= scheme_.stiffness() * weighed(operators.A, duals_.p_later, 1, dy);
    check(VecAXPBYPCZ(coarse_, 1 / scheme_.tau, -1 / scheme_.tau, 0, duals_.velocity, duals_.velocity_later));
    return value + weighed(operators.M, coarse_, 0, dy);
  }

private:
  /// error·matrix (dual + factor b); the factor for ω is τ/2, since ω = τ/2 p to leading order in τ.
  double weighed(Mat matrix, Vec dual, double factor, Vec error) {
    body_.embed(dual, dual_);
    check(VecAXPY(dual_, factor, bubbles_.last()));
    check(MatMult(matrix, dual_, product_));
    return dot(error, product_);
  }

  const EnrichedBody& body_;
  const std::vector<contact::ContactSets>& contact_;
  forward::Scheme scheme_;
  int steps_;
  Duals duals_;
  DualBubbles bubbles_;
  Residual residual_;
  double space_ = 0;
  petsc::Vector later_, dual_, product_, coarse_;
};

} // namespace

ErrorParts weighted_residual(const forward::Stepper& stepper, const EnrichedBody* enriched,
                             const Weighted& run) {
  Window motion(stepper.space(), run.motion);
  TimePart time(stepper, motion, run.motion.steps(), run.load);
  std::optional<SpacePart> space;
  if (enriched)
    space.emplace(stepper, *enriched, motion, run);
  forward::Stepper::Workspace work = stepper.workspace();
  sweep(stepper, work, run.motion.contact(), run.derivative, [&](int k, Vec p) {
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
