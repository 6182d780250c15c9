#include "forward/balance.h"
#include <cmath>
#include <utility>

namespace signorini::forward {
using petsc::check;
using petsc::dot;

namespace {

/// Component sums of a vector of V over all nodes.
std::array<double, 3> resultant(const Stepper& stepper, Vec x) {
  std::array<double, 3> sum{};
  {
    const petsc::ReadArray values(x);
    const auto dim = static_cast<std::size_t>(stepper.space().dim());
    for (std::size_t i = 0; i < values.size(); ++i)
      sum[i % dim] += values[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, stepper.space().comm());
  return sum;
}

double length(const std::array<double, 3>& x) { return std::hypot(x[0], x[1], x[2]); }

/// −(2/τ²) Σ λ_i ν_i, the contact forces on the body (N), including components that clamps hold; these act on
/// the clamps alone.
void contact_forces(const Stepper& stepper, int k, const contact::ContactState& contact, Vec force) {
  check(VecZeroEntries(force));
  if (stepper.pairs())
    contact::NormalOperator(*stepper.pairs())
        .add_whole(-1 / stepper.grid().scheme(k).impulse(), contact.lambda, force);
}

} // namespace

Balance::Balance(const Stepper& stepper, Wanted wanted) : stepper_(stepper) {
  for (petsc::Vector* x :
       {&Ay0_, &Ay1_, &Mv0_, &Mv1_, &Bw_, &w_, &jump_, &load_, &force_, &inertia_, &defect_})
    *x = stepper.space().vector();
  if (wanted.reactions)
    reaction_ = stepper.space().vector();
  if (wanted.controlled)
    loads_alone_.emplace(ForceAtStep(stepper.space(), {wanted.loads}));
}

StepBalance Balance::operator()(const Frame& frame) {
  const fem::Operators& body = stepper_.operators();
  const double tau = stepper_.grid().length(frame.k);
  StepBalance now;
  std::swap(Ay0_, Ay1_), std::swap(Mv0_, Mv1_);
  check(MatMult(body.A, frame.y1, Ay1_));
  check(MatMult(stepper_.M(), frame.v1, Mv1_));
  now.kinetic_energy = dot(frame.v1, Mv1_) / 2;
  now.elastic_energy = dot(frame.y1, Ay1_) / 2;
  now.momentum = resultant(stepper_, Mv1_);
  const double before = std::exchange(energy_, now.kinetic_energy + now.elastic_energy);
  if (frame.k == 0)
    return now;
  check(VecWAXPY(w_, -1, frame.y0, frame.y1)); // w holds y_k − y_{k−1} until it is divided by τ
  if (loads_alone_) {
    assemble(loads_alone_->at(frame.k), body, load_);
    now.load_work = dot(load_, w_);
  }
  assemble(frame.load, body, load_);
  contact_forces(stepper_, frame.k, frame.contact, force_);
  now.external_work = dot(load_, w_);
  if (!loads_alone_)
    now.load_work = now.external_work;
  now.contact_work = dot(force_, w_);
  check(VecScale(w_, 1 / tau));
  check(VecZeroEntries(Bw_));
  if (body.B) {
    check(MatMult(*body.B, w_, Bw_)); // w is (v_{k−1} + v_k)/2 unless there is a jump or a moving clamp
    now.viscous_dissipation = tau * dot(w_, Bw_);
  }
  // Defect of the equation of motion in Crank–Nicolson form: the clamps' reaction on the clamped dofs and
  // zero elsewhere.
  check(VecWAXPY(inertia_, -1, Mv0_, Mv1_));
  check(VecScale(inertia_, 1 / tau));
  check(VecCopy(inertia_, defect_));
  check(VecAXPY(defect_, 1, Bw_));
  check(VecAXPBYPCZ(defect_, 0.5, 0.5, 1, Ay0_, Ay1_));
  check(VecAXPY(defect_, -1, load_));
  check(VecAXPY(defect_, -1, force_));
  add_work_of_jumps(frame, tau, now);
  const std::array<double, 3> whole = resultant(stepper_, defect_);
  if (reaction_)
    check(VecCopy(defect_, reaction_));
  const double all_work = stepper_.motion() ? tau * dot(defect_, w_) : 0;
  stepper_.clamped().clear(defect_);
  if (stepper_.motion()) // work of the reaction
    now.external_work += all_work - tau * dot(defect_, w_);
  now.energy_residual = energy_ - before + now.viscous_dissipation - now.external_work - now.contact_work;
  const std::array<double, 3> free = resultant(stepper_, defect_);
  const std::array<double, 3> rate = resultant(stepper_, inertia_), applied = resultant(stepper_, load_);
  now.contact_force = resultant(stepper_, force_);
  for (std::size_t c = 0; c < 3; ++c)
    now.momentum_residual[c] = rate[c] - applied[c] - now.contact_force[c] - (whole[c] - free[c]);
  PetscReal internal = 0, momentum = 0;
  check(VecNorm(Ay1_, NORM_1, &internal)); // the internal forces, whose sum must cancel
  check(VecNorm(Mv1_, NORM_1, &momentum)); // the rate is a difference of these
  now.momentum_scale = length(rate) + length(applied) + length(now.contact_force) + internal + momentum / tau;
  return now;
}

void Balance::add_work_of_jumps(const Frame& frame, double tau, StepBalance& now) {
  if (!stepper_.predictor() && !stepper_.motion())
    return;
  check(VecWAXPY(jump_, 1, frame.v0, frame.v1));
  check(VecAXPBY(jump_, tau, -tau / 2, w_));
  const double all = dot(jump_, inertia_);
  stepper_.clamped().clear(jump_);
  const double free = dot(jump_, inertia_);
  if (stepper_.predictor())
    now.contact_work -= free;
  if (stepper_.motion())
    now.external_work -= all - free;
}

} // namespace signorini::forward
