// SPDX-License-Identifier: GPL-3.0-or-later
#include "adjoint/dual_bubbles.h"
#include "base/error.h"
#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace signorini::adjoint {
using petsc::check, petsc::dot;

Duals::Duals(const step::Stepper& stepper, const step::TimeGrid& grid)
    : stepper_(stepper), grid_(grid), work_(stepper.space().vector()) {
  for (petsc::Vector* x : {&p, &p_later, &velocity, &velocity_later})
    *x = stepper.space().vector();
  if (stepper.predictor())
    predictor_ = stepper.predictor()->workspace();
}

void Duals::move(int k, Vec p_k, const contact::ContactLinearisation* later) {
  Vec jump = nullptr;
  const double tau = later ? grid_.length(k + 1) : 0;
  if (const step::PredictorProjection* predictor = stepper_.predictor(); predictor && later) {
    check(VecWAXPY(work_, -2 / tau, velocity, p));
    jump = predictor->linearised_jump(later->predictor, work_, *predictor_);
  }
  std::swap(velocity, velocity_later);
  petsc::combine(velocity, tau, p, -1, velocity_later);
  if (jump)
    check(VecAXPY(velocity, tau, jump));
  std::swap(p, p_later);
  check(VecCopy(p_k, p));
}

DualBubbles::DualBubbles(const EnrichedBody& body, const step::DualAtStep& derivative,
                         const step::TimeGrid& grid)
    : body_(body), derivative_(derivative), grid_(grid), of_A_(fem::diagonal(body.operators().A)) {
  for (petsc::Vector* x : {&b_, &left_, &z_, &direction_, &image_, &work_, &diagonal_})
    *x = body.space().vector();
  if (body.operators().B)
    of_B_ = fem::diagonal(*body.operators().B);
}

void DualBubbles::set_length(double mean) {
  if (std::exchange(mean_, mean) == mean)
    return;
  check(VecAXPBY(diagonal_, mean, 0, of_A_));
  if (of_B_)
    check(VecAXPY(diagonal_, 1, of_B_));
}

void DualBubbles::add(Mat matrix, double factor) {
  body_.embed(coarse_, z_);
  check(MatMult(matrix, z_, work_));
  check(VecAXPY(left_, factor, work_));
}

void DualBubbles::residual(int k, const Duals& duals) {
  if (!coarse_)
    coarse_ = petsc::zero_like(duals.p);
  const fem::Operators& operators = body_.operators();
  const step::Scheme now = grid_.scheme(k), later = grid_.scheme(k + 1);
  step::assemble(derivative_.at(grid_.step(k)), operators, left_);
  petsc::combine(coarse_, 1 / later.tau + 2 / now.tau, duals.velocity, -1 / later.tau, duals.velocity_later);
  check(VecAXPY(coarse_, -1, duals.p));
  add(operators.M, 1);
  if (operators.B) {
    petsc::combine(coarse_, later.tau / 2, duals.p_later, -now.tau / 2, duals.p);
    add(*operators.B, 1);
    check(MatMult(*operators.B, b_, work_));
    check(VecAXPY(left_, 1, work_));
  }
  petsc::combine(coarse_, now.stiffness(), duals.p, later.stiffness(), duals.p_later);
  add(operators.A, -1);
}

void DualBubbles::apply(Vec x, const contact::ActiveSet& active, Vec out) {
  const fem::Operators& operators = body_.operators();
  check(MatMult(operators.A, x, out));
  check(VecScale(out, mean_));
  if (operators.B) {
    check(MatMult(*operators.B, x, work_));
    check(VecAXPY(out, 1, work_));
  }
  body_.keep_bubbles(active, out);
}

double DualBubbles::precondition(const contact::ActiveSet& active) {
  check(VecPointwiseDivide(z_, left_, diagonal_));
  body_.keep_bubbles(active, z_);
  return dot(z_, left_);
}

Vec DualBubbles::next(int k, const Duals& duals, const contact::ActiveSet& active) {
  set_length((grid_.length(k) + grid_.length(k + 1)) / 2);
  residual(k, duals);
  body_.keep_bubbles(active, left_);
  const double size = precondition(active);
  body_.keep_bubbles(active, b_);
  apply(b_, active, image_);
  check(VecAXPY(left_, -1, image_));
  double product = precondition(active);
  check(VecCopy(z_, direction_));
  // Of a squared norm: 1 % in the bubbles' energy norm, below the error that the estimate neglects.
  constexpr double tolerance = 1e-4;
  constexpr int most = 1000;
  const double enough = tolerance * std::max(size, product);
  for (int iteration = 0; product > enough; ++iteration) {
    if (iteration == most)
      throw SolverFailure(fmt::format(
          "the error estimate at step {}: no convergence in {} iterations, relative residual {:.2e}", k, most,
          product / std::max(size, product)));
    apply(direction_, active, image_);
    const double length = product / dot(direction_, image_);
    check(VecAXPY(b_, length, direction_));
    check(VecAXPY(left_, -length, image_));
    const double last = std::exchange(product, precondition(active));
    check(VecAYPX(direction_, product / last, z_));
  }
  return b_;
}

} // namespace signorini::adjoint
