#include "forward/step.h"
#include "base/error.h"
#include "contact/condensed_vi.h"
#include "contact/full_vi.h"
#include <cmath>

namespace signorini::forward {
using petsc::check;

Stepper::Stepper(const fem::Space& space, const fem::Operators& operators, const scene::Scene& scene, Needs needs)
    : space_(space), operators_(operators), scheme_{scene.time.step}, clamped_(space, scene.clamps),
      D_(fem::assemble_step_operator(space, scene.material, scheme_.tau)), r_(space.vector()), work_(space.vector()) {
  if (scene.contact)
    constraints_.emplace(space, clamped_, *scene.contact);
  check(MatDuplicate(D_, MAT_COPY_VALUES, R_.put()));
  check(MatAXPY(R_, -2 * scheme_.stiffness(), operators.A, SAME_NONZERO_PATTERN));
  clamped_.decouple(D_);
  factorisation_.emplace(D_);
  if (!constraints_)
    return;
  complementarity_.emplace(*constraints_, D_);
  const bool full = scene.solver.vi == "full";
  if (needs.sliding || !full)
    condensation_.emplace(*constraints_, *factorisation_, r_);
  if (full)
    vi_ = std::make_unique<contact::FullVi>(*constraints_, D_, *complementarity_);
  else
    vi_ = std::make_unique<contact::CondensedVi>(*constraints_, *condensation_, *factorisation_, *complementarity_);
}

void Stepper::right_hand_side(Vec y0, Vec v0, Vec load) const {
  check(MatMult(operators_.M, v0, r_));
  check(VecScale(r_, scheme_.momentum()));
  check(MatMultAdd(R_, y0, r_, r_));
  check(VecAXPY(r_, scheme_.impulse(), load));
  clamped_.clear(r_);
}

void Stepper::velocity(Vec y0, Vec v0, Vec y1, Vec v1) const {
  check(VecWAXPY(v1, -1, y0, y1));
  check(VecScale(v1, scheme_.rate()));
  check(VecAXPY(v1, -1, v0));
}

contact::ContactState Stepper::step(Vec y0, Vec v0, Vec load, const contact::ContactState& previous, Vec y1,
                                    Vec v1) const {
  right_hand_side(y0, v0, load);
  contact::ContactState contact;
  if (vi_) {
    check(VecCopy(y0, y1));
    contact = vi_->solve(r_, previous, y1);
  } else {
    factorisation_->solve(r_, y1);
  }
  velocity(y0, v0, y1, v1);
  PetscReal size = 0;
  check(VecNorm(v1, NORM_2, &size));
  if (!std::isfinite(size))
    throw SolverFailure("the solution is not finite");
  return contact;
}

void Stepper::solve_sliding(const contact::ContactState& contact, Vec p) const {
  if (constraints_)
    condensation_->solve_sliding(r_, contact.active(), p);
  else
    factorisation_->solve(r_, p);
}

void Stepper::linearised_step(Vec y0, Vec v0, Vec load, const contact::ContactState& contact, Vec y1, Vec v1) const {
  right_hand_side(y0, v0, load);
  solve_sliding(contact, y1);
  velocity(y0, v0, y1, v1);
}

void Stepper::transposed_step(const contact::ContactState& contact, Vec ybar, Vec vbar, Vec p) const {
  // v_k = rate (y_k − y_{k−1}) − v_{k−1} passes its dual on to y_k, to y_{k−1} and to v_{k−1}.
  check(VecWAXPY(r_, scheme_.rate(), vbar, ybar));
  clamped_.clear(r_);
  solve_sliding(contact, p);
  check(MatMult(R_, p, ybar));
  check(VecAXPY(ybar, -scheme_.rate(), vbar));
  check(MatMult(operators_.M, p, work_));
  check(VecAXPBY(vbar, scheme_.momentum(), -1, work_));
}

} // namespace signorini::forward
