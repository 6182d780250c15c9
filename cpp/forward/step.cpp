#include "forward/step.h"
#include "base/counters.h"
#include "base/error.h"
#include "contact/massless.h"
#include <algorithm>
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
  if (std::ranges::any_of(scene.contacts, &scene::Contact::massless))
    move_mass(scene, D);
  if (constraints_ && scene.time.stabilized()) {
    predictor_.emplace(fem::assemble_mass(space, scene.materials), operators.M, clamped_, *constraints_,
                       scene.solver, needs.sliding);
    moved_ = space.vector();
  }
  R_ = fem::shifted(operators.A, D, 2 * scheme_.stiffness());
  if (PrescribedMotion::in(scene.clamps))
    motion_.emplace(space, scene.clamps, D, scheme_);
  clamped_diagonal_ = clamped_.decouple(D);
  solver_.emplace(std::move(D), constraints(), scene.solver, needs.sliding);
}

void Stepper::move_mass(const scene::Scene& scene, Mat D) {
  std::vector<bool> massless;
  for (const scene::Contact& contact : scene.contacts)
    massless.push_back(contact.massless());
  const petsc::Matrix M = fem::assemble_mass(space_, scene.materials);
  const petsc::Matrix moved = contact::massless(space_, *constraints_, massless, M);
  check(MatAXPY(D, -1, M, SUBSET_NONZERO_PATTERN));
  check(MatAXPY(D, 1, moved, DIFFERENT_NONZERO_PATTERN));
  massless_ = fem::symmetric_half(moved);
}

double Stepper::scheme_bytes() const {
  return (massless_ ? petsc::bytes(*massless_) : 0) + (predictor_ ? predictor_->bytes() : 0);
}

void Stepper::right_hand_side(Vec x, double a, Vec z, double b, Functional source) const {
  const std::optional<double> rho = massless_ ? std::nullopt : operators_.uniform_density;
  if (!source.density) {
    check(VecAXPBY(work_, a, 0, z));
    check(MatMult(M(), work_, r_));
  } else if (rho) { // M = ρ W: one product for both terms
    check(VecAXPBYPCZ(work_, a, b / *rho, 0, z, source.density));
    check(MatMult(M(), work_, r_));
  } else {
    check(MatMult(M(), z, r_));
    check(MatMult(*operators_.W, source.density, work_));
    check(VecAXPBY(r_, b, a, work_));
  }
  check(MatMultAdd(R_, x, r_, r_));
  if (source.vector)
    check(VecAXPY(r_, b, source.vector));
  clamped_.clear(r_);
}

Vec Stepper::with_jump(Vec x, double c, Vec jump) const {
  if (!jump)
    return x;
  check(VecWAXPY(moved_, c, jump, x));
  return moved_;
}

Vec Stepper::predicted(Vec y, Vec v) const {
  check(VecWAXPY(work_, scheme_.tau, v, y));
  return work_;
}

void Stepper::velocity(Vec y0, Vec v0, Vec jump, Vec y1, Vec v1) const {
  const double rate = scheme_.rate();
  {
    const petsc::ReadArray from(y0), to(y1), before(v0);
    const petsc::WriteArray after(v1);
    for (std::size_t i = 0; i < after.size(); ++i) // in one pass; subtracts before scaling
      after[i] = rate * (to[i] - from[i]) - before[i];
  }
  if (jump)
    check(VecAXPY(v1, -rate, jump));
}

void Stepper::step(int k, Vec y0, Vec v0, NodalForce load, const contact::ContactSets& previous,
                   contact::ContactState& contact, Vec y1, Vec v1) const {
  const std::span<const double> psi =
      constraints_ ? constraints_->psi(scheme_.time(k)) : std::span<const double>();
  const Vec jump =
      predictor_ ? predictor_->jump(psi, predicted(y0, v0), previous.predictor, contact.predictor) : nullptr;
  const Vec momentum = with_jump(v0, 1 / scheme_.tau, jump);
  right_hand_side(y0, scheme_.momentum(), motion_ ? motion_->driving(k, y0, momentum) : momentum,
                  scheme_.impulse(), load);
  if (motion_)
    motion_->apply(k, clamped_, clamped_diagonal_, r_);
  if (const contact::ViSolver* vi = solver_->vi())
    vi->solve(r_, psi, previous, contact, y1);
  else
    solver_->linear().solve(r_, y1);
  velocity(y0, v0, jump, y1, v1);
  if (motion_)
    motion_->copy(motion_->velocity(k), v1);
  PetscReal size = 0;
  check(VecNorm(v1, NORM_2, &size));
  if (!std::isfinite(size))
    throw SolverFailure("the solution is not finite");
  ++steps;
}

void Stepper::solve_sliding(const contact::ActiveSet& active, Vec p) const {
  if (const contact::ActiveSetKkt* sliding = solver_->sliding())
    sliding->solve_sliding(r_, active, p);
  else
    solver_->linear().solve(r_, p);
}

void Stepper::solve_one_sided(contact::ContactSets& contact, Vec p) const {
  const auto m = static_cast<std::size_t>(constraints_->count());
  std::vector<double> force(m), motion(m);
  contact::ActiveSet& closed = contact.active;
  const petsc::Vector residual = petsc::zero_like(p);
  // After so many changes of the set one candidate changes at a time, which does not cycle for long.
  const int several = 2 * static_cast<int>(contact.weak.size()) + 10;
  for (int change = 0; change < 20 * several; ++change) {
    solve_sliding(closed, p);
    check(MatMult(R_, p, residual)); // D p = R p + 2 stiffness() A p
    check(MatMult(operators_.A, p, work_));
    check(VecAXPBYPCZ(residual, 1, -2 * scheme_.stiffness(), -1, r_, work_));
    constraints_->normal_components(residual, force);
    constraints_->normal_components(p, motion);
    PetscReal largest_force = 0, largest_motion = 0;
    check(VecNorm(r_, NORM_INFINITY, &largest_force));
    check(VecNorm(p, NORM_INFINITY, &largest_motion));
    constexpr double rounding = 1e-10;
    contact::ActiveSet next;
    bool settled = true;
    for (std::size_t i = 0; i < m; ++i) {
      const bool is_closed = std::ranges::binary_search(closed, static_cast<int>(i));
      const bool wrong =
          std::ranges::binary_search(contact.weak, static_cast<int>(i)) &&
          (is_closed ? force[i] < -rounding * largest_force : motion[i] > rounding * largest_motion);
      const bool flips = wrong && (settled || change < several);
      settled = settled && !wrong;
      if (is_closed != flips)
        next.push_back(static_cast<int>(i));
    }
    if (settled)
      return;
    closed = std::move(next);
  }
  throw SolverFailure("the weak contact of a linearised step did not settle");
}

Vec Stepper::linearised_right_hand_side(Vec y0, Vec v0, NodalForce load,
                                        const contact::ContactSets& contact) const {
  const Vec jump = predictor_ ? predictor_->linearised_jump(contact.predictor, predicted(y0, v0)) : nullptr;
  right_hand_side(y0, scheme_.momentum(), with_jump(v0, 1 / scheme_.tau, jump), scheme_.impulse(), load);
  return jump;
}

void Stepper::linearised_step(Vec y0, Vec v0, NodalForce load, const contact::ContactSets& contact, Vec y1,
                              Vec v1) const {
  const Vec jump = linearised_right_hand_side(y0, v0, load, contact);
  solve_sliding(contact.active, y1);
  velocity(y0, v0, jump, y1, v1);
  ++linearised_steps;
}

void Stepper::one_sided_step(Vec y0, Vec v0, NodalForce load, contact::ContactSets& contact, Vec y1,
                             Vec v1) const {
  const Vec jump = linearised_right_hand_side(y0, v0, load, contact);
  if (!contact.weak.empty())
    solve_one_sided(contact, y1);
  else
    solve_sliding(contact.active, y1);
  velocity(y0, v0, jump, y1, v1);
  ++linearised_steps;
}

void Stepper::adjoint_step(const contact::ContactSets& contact, const contact::ContactSets* next,
                           StateDual derivative, Vec p_next, Vec q, Vec p) const {
  const Vec jump = predictor_ && next ? predictor_->linearised_jump(next->predictor, q) : nullptr;
  right_hand_side(p_next, -scheme_.momentum(), with_jump(q, 1.5, jump), 1, derivative);
  solve_sliding(contact.active, p);
  const double rate = scheme_.rate();
  {
    const petsc::ReadArray later(p_next), now(p);
    const petsc::WriteArray velocity(q);
    for (std::size_t i = 0; i < velocity.size(); ++i)
      velocity[i] = rate * (later[i] - now[i]) - velocity[i];
  }
  if (jump)
    check(VecAXPY(q, -2, jump));
  ++adjoint_steps;
}

} // namespace signorini::forward
