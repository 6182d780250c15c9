#include "forward/step.h"
#include "base/counters.h"
#include "base/error.h"
#include "contact/lcp/primal_dual.h"
#include "contact/massless.h"
#include "linalg/threaded_product.h"
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
    : space_(space), operators_(operators), grid_{scene.time.step}, clamped_(space, scene.clamps) {
  if (!scene.contacts.empty())
    pairs_.emplace(space, clamped_, scene.contacts, scene.time);
  petsc::Matrix D = fem::assemble_step_operator(space, scene.materials, grid_.tau);
  scene::Solver solver = scene.solver;
  if (needs.iterative)
    solver.linear = scene::LinearMethod::iterative;
  const double solves = needs.passes * scene.time.steps;
  if (std::ranges::any_of(scene.contacts, &scene::Contact::massless))
    move_mass(scene, D);
  if (pairs_ && scene.time.stabilized())
    predictor_.emplace(fem::assemble_mass(space, scene.materials), operators.M, clamped_, *pairs_, solver,
                       needs.sliding, solves);
  R_ = fem::shifted(operators.A, D, 2 * Scheme{grid_.tau}.stiffness());
  thread_products(R_);
  thread_products(M());
  if (PrescribedMotion::in(scene.clamps))
    motion_.emplace(space, scene.clamps, D, grid_);
  clamped_diagonal_ = clamped_.decouple(D);
  fem::attach_rigid_motions(D, space);
  solver_.emplace(std::move(D), pairs(), solver, needs.sliding, solves);
}

void Stepper::move_mass(const scene::Scene& scene, Mat D) {
  const petsc::Matrix M = fem::assemble_mass(space_, scene.materials);
  const petsc::Matrix moved =
      contact::massless(space_, *pairs_, contact::massless_obstacles(scene.contacts), M);
  check(MatAXPY(D, -1, M, SUBSET_NONZERO_PATTERN));
  check(MatAXPY(D, 1, moved, DIFFERENT_NONZERO_PATTERN));
  massless_ = fem::symmetric_half(moved);
}

double Stepper::scheme_bytes() const {
  return (massless_ ? petsc::bytes(*massless_) : 0) + (predictor_ ? predictor_->bytes() : 0);
}

Stepper::Workspace Stepper::workspace() const {
  Workspace work{.r = space_.vector(), .work = space_.vector()};
  if (pairs_) {
    work.gaps = pairs_->gaps();
    work.contact = solver_->contact()->workspace();
  }
  if (predictor_) {
    work.moved = space_.vector();
    work.predictor = predictor_->workspace();
  }
  if (motion_)
    work.motion = motion_->storage();
  return work;
}

void Stepper::right_hand_side(Vec x, double a, Vec z, double b, Functional source, Workspace& work) const {
  const std::optional<double> rho = massless_ ? std::nullopt : operators_.uniform_density;
  if (!source.density) {
    check(VecAXPBY(work.work, a, 0, z));
    check(MatMult(M(), work.work, work.r));
  } else if (rho) { // M = ρ W: one product for both terms
    check(VecAXPBYPCZ(work.work, a, b / *rho, 0, z, source.density));
    check(MatMult(M(), work.work, work.r));
  } else {
    check(MatMult(M(), z, work.r));
    check(MatMult(*operators_.W, source.density, work.work));
    check(VecAXPBY(work.r, b, a, work.work));
  }
  check(MatMultAdd(R_, x, work.r, work.r));
  if (source.vector)
    check(VecAXPY(work.r, b, source.vector));
  clamped_.clear(work.r);
}

namespace {

/// x + c j in `work`, or x itself without a jump j.
Vec with_jump(Vec x, double c, Vec jump, Vec work) {
  if (!jump)
    return x;
  check(VecWAXPY(work, c, jump, x));
  return work;
}

/// The predictor y + τ v in `work`.
Vec predicted(const Scheme& scheme, Motion from, Vec work) {
  check(VecWAXPY(work, scheme.tau, from.v, from.y));
  return work;
}

/// v ← rate() (y_k − y_{k−1} − j) − v_{k−1}.
void set_velocity(const Scheme& scheme, Motion from, Vec jump, Motion to) {
  const double rate = scheme.rate();
  {
    const petsc::ReadArray before(from.y), after(to.y), velocity(from.v);
    const petsc::WriteArray v(to.v);
    for (std::size_t i = 0; i < v.size(); ++i) // in one pass; subtracts before scaling
      v[i] = rate * (after[i] - before[i]) - velocity[i];
  }
  if (jump)
    check(VecAXPY(to.v, -rate, jump));
}

} // namespace

void Stepper::step(const StepInput& in, const StepOutput& out, Workspace& work) const {
  const Scheme scheme = grid_.scheme(in.k);
  const std::span<const double> psi =
      pairs_ ? pairs_->psi(grid_.time(in.k), *work.gaps) : std::span<const double>();
  const Vec jump = predictor_
                       ? predictor_->jump(psi, predicted(scheme, in.from, work.work), in.previous.predictor,
                                          out.contact.predictor, *work.predictor)
                       : nullptr;
  Vec momentum = with_jump(in.from.v, scheme.jump_rate(), jump, work.moved);
  if (motion_) {
    motion_->evaluate(in.k, *work.motion);
    momentum = motion_->driving(*work.motion, in.from.y, momentum);
  }
  right_hand_side(in.from.y, scheme.momentum(), momentum, scheme.impulse(), in.load, work);
  if (motion_)
    motion_->apply(*work.motion, clamped_, clamped_diagonal_, work.r);
  if (const contact::ContactStepSolver* solver = solver_->contact())
    solver->solve(work.r, psi, in.previous.active, out.contact, out.to.y, *work.contact);
  else
    solver_->linear().solve(work.r, out.to.y);
  set_velocity(scheme, in.from, jump, out.to);
  if (motion_)
    motion_->copy(work.motion->velocity, out.to.v);
  PetscReal size = 0;
  check(VecNorm(out.to.v, NORM_2, &size));
  if (!std::isfinite(size))
    throw SolverFailure("the solution is not finite");
  ++steps;
}

void Stepper::solve_sliding(const contact::ActiveSet& active, std::span<const double> normal, Vec p,
                            Workspace& work) const {
  if (const contact::ContactStepSolver* solver = solver_->contact())
    solver->solve_guided(work.r, active, normal, p, *work.contact);
  else
    solver_->linear().solve(work.r, p);
}

void Stepper::solve_one_sided(const Scheme& scheme, contact::ContactSets& contact, Vec p,
                              Workspace& work) const {
  const contact::NormalOperator N(*pairs_);
  const auto m = static_cast<std::size_t>(pairs_->count());
  std::vector<double> force(m), motion(m);
  contact::ActiveSet &closed = contact.active, next, wrong;
  const petsc::Vector residual = petsc::zero_like(p);
  for (contact::BlockPivoting pivoting(*pairs_);; pivoting.advance(closed, next, wrong)) {
    solve_sliding(closed, {}, p, work);
    check(MatMult(R_, p, residual)); // D p = R p + 2 stiffness() A p
    check(MatMult(operators_.A, p, work.work));
    check(VecAXPBYPCZ(residual, 1, -2 * scheme.stiffness(), -1, work.r, work.work));
    N.forces(closed, residual, force);
    N.normal_components(p, motion);
    PetscReal largest_force = 0, largest_motion = 0;
    check(VecNorm(work.r, NORM_INFINITY, &largest_force));
    check(VecNorm(p, NORM_INFINITY, &largest_motion));
    constexpr double rounding = 1e-10;
    next.clear();
    for (int i = 0; i < pairs_->count(); ++i) {
      const bool is_closed = std::ranges::binary_search(closed, i);
      const bool flips =
          std::ranges::binary_search(contact.weak, i) &&
          (is_closed ? force[i] < -rounding * largest_force : motion[i] > rounding * largest_motion);
      if (is_closed != flips)
        next.push_back(i);
    }
    if (next == closed)
      return;
  }
}

Vec Stepper::linearised_right_hand_side(const LinearisedStep& step, const contact::ContactSets& contact,
                                        Workspace& work) const {
  const Scheme scheme = grid_.scheme(step.k);
  const Vec jump =
      predictor_ ? predictor_->linearised_jump(contact.predictor, predicted(scheme, step.from, work.work),
                                               *work.predictor, step.predictor)
                 : nullptr;
  right_hand_side(step.from.y, scheme.momentum(),
                  with_jump(step.from.v, scheme.jump_rate(), jump, work.moved), scheme.impulse(), step.load,
                  work);
  return jump;
}

void Stepper::linearised_step(const LinearisedStep& step, const contact::ContactSets& contact,
                              Workspace& work) const {
  const Vec jump = linearised_right_hand_side(step, contact, work);
  solve_sliding(contact.active, step.normal, step.to.y, work);
  set_velocity(grid_.scheme(step.k), step.from, jump, step.to);
  ++linearised_steps;
}

void Stepper::one_sided_step(const LinearisedStep& step, contact::ContactSets& contact,
                             Workspace& work) const {
  const Vec jump = linearised_right_hand_side(step, contact, work);
  if (!contact.weak.empty())
    solve_one_sided(grid_.scheme(step.k), contact, step.to.y, work);
  else
    solve_sliding(contact.active, step.normal, step.to.y, work);
  set_velocity(grid_.scheme(step.k), step.from, jump, step.to);
  ++linearised_steps;
}

void Stepper::adjoint_step(const AdjointStep& step, Workspace& work) const {
  const Scheme scheme = grid_.scheme(step.k);
  const Vec jump = predictor_ && step.next ? predictor_->linearised_jump(step.next->predictor, step.q,
                                                                         *work.predictor, step.predictor)
                                           : nullptr;
  right_hand_side(step.p_next, -scheme.momentum(), with_jump(step.q, Scheme::dual_jump(), jump, work.moved),
                  1, step.derivative, work);
  solve_sliding(step.contact.active, step.normal, step.p, work);
  const double rate = scheme.rate();
  {
    const petsc::ReadArray later(step.p_next), now(step.p);
    const petsc::WriteArray q(step.q);
    for (std::size_t i = 0; i < q.size(); ++i)
      q[i] = rate * (later[i] - now[i]) - q[i];
  }
  if (jump)
    check(VecAXPY(step.q, Scheme::dual_velocity_jump(), jump));
  ++adjoint_steps;
}

} // namespace signorini::forward
