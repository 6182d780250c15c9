#include "forward/step.h"
#include "base/counters.h"
#include "base/error.h"
#include <cmath>

namespace signorini::forward {
using petsc::check;

namespace {
long &steps = count("steps"), &linearised_steps = count("linearised steps"),
     &adjoint_steps = count("adjoint steps");
}

Stepper::Stepper(const fem::Space& space, const fem::Operators& operators, const scene::Scene& scene,
                 Needs needs)
    : space_(space), operators_(operators), scheme_{scene.time.step}, clamped_(space, scene.clamps),
      r_(space.vector()), work_(space.vector()) {
  if (!scene.contacts.empty())
    constraints_.emplace(space, clamped_, scene.contacts);
  petsc::Matrix D = fem::assemble_step_operator(space, scene.materials, scheme_.tau);
  R_ = fem::shifted(operators.A, D, 2 * scheme_.stiffness());
  if (PrescribedMotion::in(scene.clamps))
    motion_.emplace(space, scene.clamps, D, scheme_);
  clamped_diagonal_ = clamped_.decouple(D);
  solver_.emplace(std::move(D), constraints(), scene.solver, needs.sliding);
}

void Stepper::right_hand_side(Vec x, double a, Vec z, double b, StepLoad load) const {
  const std::optional<double> rho = operators_.uniform_density;
  if (!load.density) {
    check(VecAXPBY(work_, a, 0, z));
    check(MatMult(operators_.M, work_, r_));
  } else if (rho) { // one product does for both
    check(VecAXPBYPCZ(work_, a, b / *rho, 0, z, load.density));
    check(MatMult(operators_.M, work_, r_));
  } else {
    check(MatMult(operators_.M, z, r_));
    check(MatMult(operators_.W, load.density, work_));
    check(VecAXPBY(r_, b, a, work_));
  }
  check(MatMultAdd(R_, x, r_, r_));
  if (load.force)
    check(VecAXPY(r_, b, load.force));
  clamped_.clear(r_);
}

void Stepper::velocity(Vec y0, Vec v0, Vec y1, Vec v1) const {
  const petsc::ReadArray from(y0), to(y1), before(v0);
  const petsc::WriteArray after(v1);
  const double rate = scheme_.rate();
  for (std::size_t i = 0; i < after.size(); ++i) // one pass, and the difference before it is scaled
    after[i] = rate * (to[i] - from[i]) - before[i];
}

void Stepper::step(int k, Vec y0, Vec v0, StepLoad load, const contact::ContactState& previous,
                   contact::ContactState& contact, Vec y1, Vec v1) const {
  right_hand_side(y0, scheme_.momentum(), v0, scheme_.impulse(), load);
  if (motion_)
    motion_->apply(k, clamped_, clamped_diagonal_, r_);
  if (const contact::ViSolver* vi = solver_->vi())
    vi->solve(r_, constraints_->psi(scheme_.time(k)), previous, contact, y1);
  else
    solver_->linear().solve(r_, y1);
  velocity(y0, v0, y1, v1);
  PetscReal size = 0;
  check(VecNorm(v1, NORM_2, &size));
  if (!std::isfinite(size))
    throw SolverFailure("the solution is not finite");
  ++steps;
}

void Stepper::solve_sliding(const contact::ContactState& contact, Vec p) const {
  if (const contact::SlidingSolver* sliding = solver_->sliding())
    sliding->solve_sliding(r_, contact.active, p);
  else
    solver_->linear().solve(r_, p);
}

void Stepper::linearised_step(Vec y0, Vec v0, StepLoad load, const contact::ContactState& contact, Vec y1,
                              Vec v1) const {
  right_hand_side(y0, scheme_.momentum(), v0, scheme_.impulse(), load);
  solve_sliding(contact, y1);
  velocity(y0, v0, y1, v1);
  ++linearised_steps;
}

void Stepper::adjoint_step(const contact::ContactState& contact, StepLoad derivative, Vec p_next, Vec q,
                           Vec p) const {
  right_hand_side(p_next, -scheme_.momentum(), q, 1, derivative);
  solve_sliding(contact, p);
  const petsc::ReadArray next(p_next), now(p);
  const petsc::WriteArray velocity(q);
  const double rate = scheme_.rate();
  for (std::size_t i = 0; i < velocity.size(); ++i)
    velocity[i] = rate * (next[i] - now[i]) - velocity[i];
  ++adjoint_steps;
}

} // namespace signorini::forward
