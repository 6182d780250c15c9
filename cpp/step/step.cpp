// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/step.h"
#include "base/error.h"
#include "base/timers.h"
#include "contact/lcp/primal_dual.h"
#include "contact/mass_redistribution.h"
#include "contact/solver/law_solver.h"
#include "fem/wave_time.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace signorini::step {
using petsc::check;

namespace {
long &steps = count("steps"), &linearised_steps = count("linearised steps");

/// Returns the least time in which a pressure wave crosses an element, s, over the elements at contact groups
/// and at tractions that vary in time; over all elements if body loads or forces at points vary or the scene
/// has no contact.
double wave_time(const fem::Space& space, const scene::Scene& scene) {
  std::vector<fem::Surface> surfaces;
  for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
    const scene::Contact& contact = scene.contacts[i];
    const std::string key = scene::contact_key(scene.contacts, i);
    surfaces.push_back({contact.on, key + ".on"});
    if (contact.against)
      surfaces.push_back({*contact.against, key + ".against"});
  }
  const auto varies = [](const scene::Components& load, const std::string& key) {
    return scene::Field(load, key, true).depends_on_time();
  };
  bool everywhere = surfaces.empty();
  if (scene.load) {
    const scene::Load& load = *scene.load;
    everywhere = everywhere || (load.body && varies(*load.body, "load.body")) ||
                 (load.gravity && varies(*load.gravity, "load.gravity"));
    for (std::size_t i = 0; i < load.tractions.size(); ++i) {
      const std::string key = fmt::format("load.traction[{}]", i);
      if (varies(load.tractions[i].value, key + ".value"))
        surfaces.push_back({load.tractions[i].on, key + ".on"});
    }
    for (std::size_t i = 0; i < load.points.size(); ++i)
      everywhere = everywhere || varies(load.points[i].value, fmt::format("load.point[{}].value", i));
  }
  if (everywhere)
    surfaces.clear();
  return fem::least_wave_time(space, scene.materials, surfaces);
}

/// Whether the candidates of two steppers have the same rows.
bool same_rows(const contact::ContactPairs* one, const contact::ContactPairs* other) {
  return one && other ? one->rows().equals(other->rows()) : one == other;
}
/// Whether they constrain the same dofs, in the same order.
bool same_dofs(const contact::ContactPairs* one, const contact::ContactPairs* other) {
  return one && other ? one->rows().dofs() == other->rows().dofs() : one == other;
}

} // namespace

Stepper::Stepper(const fem::Space& space, const fem::Operators& operators, const scene::Scene& scene,
                 Needs needs, const Stepper* like)
    : space_(space), operators_(operators), contact_scheme_(scene.contact_scheme()),
      wave_time_(step::wave_time(space, scene)), step_lengths_(step::step_lengths(scene, wave_time_)),
      end_(step_lengths_ ? step_lengths_->end : scene.time.steps * scene.time.step),
      first_length_(step_lengths_ ? step_lengths_->shortest_step() : scene.time.step),
      clamped_(space, scene.clamps) {
  if (!scene.contacts.empty())
    pairs_.emplace(space, clamped_, scene.contacts, scene.time);
  scene::Solver solver = scene.solver;
  if (needs.iterative)
    solver.linear = scene::LinearMethod::iterative;
  const double solves = step_lengths_ ? 0 : needs.passes * scene.time.steps;
  const bool loses_mass = std::ranges::any_of(scene.contacts, &scene::Contact::loses_mass),
             same = like && same_rows(pairs(), like->pairs());
  if (like && (!like->solver().shares() || (loses_mass ? !same : !same_dofs(pairs(), like->pairs()))))
    like = nullptr; // D or its solver is another one
  if (like)
    moved_ = like->moved_;
  else if (loses_mass)
    move_mass(scene);
  if (pairs_ && contact_scheme_ == scene::ContactScheme::contact_stabilized)
    add_predictor(scene, solver, needs.derivatives, solves, like);
  if (MovingClamps::in(scene.clamps))
    moving_clamps_.emplace(space, scene.clamps);
  lengths_.emplace(
      space, operators.A, clamped_, pairs(), solver, needs.derivatives, solves, moving_clamps_.has_value(),
      [this, &materials = scene.materials](double tau) {
        petsc::Matrix D = fem::assemble_step_operator(space_, materials, tau);
        operators_.add_surroundings(D, tau);
        if (moved_->mass) {
          check(MatAXPY(D, -1, moved_->body, SUBSET_NONZERO_PATTERN));
          check(MatAXPY(D, 1, moved_->redistributed, DIFFERENT_NONZERO_PATTERN));
        }
        return D;
      },
      like ? &*like->lengths_ : nullptr, same);
  const StepOperators::PerStepLength& first = of_length(first_length_); // fails here rather than in a step
  product_ = like ? like->product_ : std::make_shared<LaneProduct>(first.shared_R, M());
}

void Stepper::move_mass(const scene::Scene& scene) {
  moved_->body = fem::assemble_mass(space_, scene.materials);
  petsc::Matrix E = contact::velocity_extrapolation(space_, *pairs_, scene.contacts, moved_->body);
  moved_->redistributed = contact::redistributed_mass(E, moved_->body);
  moved_->mass = symmetric_half(moved_->redistributed);
  if (contact_scheme_ == scene::ContactScheme::contact_stabilized)
    moved_->extrapolation = std::move(E);
}

void Stepper::add_predictor(const scene::Scene& scene, const scene::Solver& solver, bool derivatives,
                            double solves, const Stepper* like) {
  if (frictional()) // the predictor is projected along normals only
    smooth_pairs_.emplace(space_, clamped_, contact::without_friction(scene.contacts), scene.time);
  const contact::ContactPairs& projected = smooth_pairs_ ? *smooth_pairs_ : *pairs_;
  if (like && like->predictor_->shares()) {
    const contact::ContactPairs& known = like->smooth_pairs_ ? *like->smooth_pairs_ : *like->pairs_;
    predictor_.emplace(*like->predictor_, moved_->predictor ? Mat(moved_->predictor) : Mat(operators_.M),
                       clamped_, projected, same_rows(&projected, &known), solver);
    return;
  }
  petsc::Matrix blocks;
  if (moved_->extrapolation) {
    check(MatDuplicate(moved_->redistributed, MAT_COPY_VALUES, blocks.put()));
    contact::add_removed_mass(moved_->extrapolation, moved_->body, blocks);
    moved_->predictor = symmetric_half(blocks);
  } else
    blocks = fem::assemble_mass(space_, scene.materials);
  predictor_.emplace(std::move(blocks), moved_->predictor ? Mat(moved_->predictor) : Mat(operators_.M),
                     clamped_, projected, solver, derivatives, solves);
}

double Stepper::predictor_bytes() const {
  return (predictor_ ? predictor_->bytes() : 0) + (moved_->predictor ? petsc::bytes(moved_->predictor) : 0);
}

double Stepper::redistribution_bytes() const {
  return (moved_->mass ? petsc::bytes(moved_->mass) : 0) +
         (moved_->extrapolation ? petsc::bytes(moved_->extrapolation) : 0);
}

Stepper::Workspace Stepper::workspace() const {
  Workspace work{.r = space_.vector(), .work = space_.vector(), .moved = space_.vector()};
  if (branches() > 0) {
    work.of_branches = space_.vector();
    work.weights.resize(branches());
    work.weights_p.resize(branches());
  }
  if (frictional())
    for (std::vector<double>* values : {&work.slip_gaps, &work.motion, &work.mu})
      values->resize(rows());
  if (pairs_) {
    work.gaps = pairs_->gaps();
    work.contact = solver().contact()->workspace();
  }
  if (predictor_)
    work.predictor = predictor_->workspace();
  if (moving_clamps_)
    work.moving_clamps = moving_clamps_->storage();
  return work;
}

void Stepper::right_hand_side(Mat R, Vec x, double a, Vec z, double b, Functional source,
                              Workspace& work) const {
  // r = R x + M (a z) + b source, with source = W density + vector
  const std::optional<double> rho = moved_->mass ? std::nullopt : operators_.uniform_density;
  if (source.density && !rho) {
    check(MatMult(M(), z, work.r));
    check(MatMult(*operators_.W, source.density, work.work));
    check(VecAXPBY(work.r, b, a, work.work));
    check(MatMultAdd(R, x, work.r, work.r));
  } else {
    if (source.density) // M = ρ W: one product for both terms
      petsc::combine(work.work, a, z, b / *rho, source.density);
    else
      check(VecAXPBY(work.work, a, 0, z));
    product_->multiply(R, x, work.work, work.r);
  }
  if (source.vector)
    check(VecAXPY(work.r, b, source.vector));
  clamped_.clear(work.r);
}

void Stepper::subtract_branch_forces(const Scheme& scheme, const State& from, Workspace& work) const {
  if (!operators_.relaxation)
    return;
  const fem::Relaxation& relaxation = *operators_.relaxation;
  for (std::size_t j = 0; j < branches(); ++j)
    work.weights[j] = -scheme.impulse() * scene::branch_step(scheme.tau, relaxation.branches()[j].time).gain;
  relaxation.add({.weights = work.weights, .vectors = from.q()}, work.r, work.of_branches);
  clamped_.clear(work.r);
}

void Stepper::set_branches(const Scheme& scheme, const State& from, const State& to) const {
  const petsc::ReadArray before(from.y()), after(to.y());
  for (std::size_t j = 0; j < branches(); ++j) {
    const auto [gain, decay] = scene::branch_step(scheme.tau, operators_.relaxation->branches()[j].time);
    const petsc::ReadArray last(from.q()[j]);
    const petsc::WriteArray q(to.q()[j]);
    for (std::size_t i = 0; i < q.size(); ++i)
      q[i] = decay * last[i] + gain * (after[i] - before[i]);
  }
}

namespace {

/// Returns x + c jump, stored in `work`; x itself if `jump` is null.
Vec with_jump(Vec x, double c, Vec jump, Vec work) {
  if (!jump)
    return x;
  check(VecWAXPY(work, c, jump, x));
  return work;
}

/// Returns the predictor y + τ v, stored in `work`.
Vec predicted(const Scheme& scheme, const State& from, Vec work) {
  check(VecWAXPY(work, scheme.tau, from.v(), from.y()));
  return work;
}

/// Sets the velocity v = rate() (y_k − y_{k−1} − j) − v_{k−1} after a step, rate() = 2/τ (4.22).
void set_velocity(const Scheme& scheme, const State& from, Vec jump, const State& to) {
  const double rate = scheme.rate();
  {
    const petsc::ReadArray before(from.y()), after(to.y()), velocity(from.v());
    const petsc::WriteArray v(to.v());
    for (std::size_t i = 0; i < v.size(); ++i) // in one pass; subtracts before scaling
      v[i] = rate * (after[i] - before[i]) - velocity[i];
  }
  if (jump)
    check(VecAXPY(to.v(), -rate, jump));
}

} // namespace

void Stepper::extrapolate(Vec v, Vec work) const {
  if (!moved_->extrapolation)
    return;
  check(MatMult(moved_->extrapolation, v, work));
  check(VecCopy(work, v));
}

void Stepper::step(const StepInput& in, const StepOutput& out, Workspace& work) const {
  const Scheme scheme = in.step.scheme();
  const StepOperators::PerStepLength& with = of_length(scheme.tau);
  const std::span<const double> normal_psi =
      pairs_ ? pairs_->psi(in.step.end, *work.gaps) : std::span<const double>();
  std::span<const double> psi = normal_psi;
  const Vec jump = predictor_
                       ? predictor_->jump(psi, predicted(scheme, in.from, work.work), in.previous.predictor,
                                          out.contact.predictor, *work.predictor)
                       : nullptr;
  Vec momentum = with_jump(in.from.v(), scheme.jump_rate(), jump, work.moved); // v_{k−1} + j/τ
  if (moving_clamps_) {
    moving_clamps_->evaluate(in.step, *work.moving_clamps);
    momentum = moving_clamps_->starting_velocity(*work.moving_clamps, in.from.y(), momentum);
  }
  // (4.21): r = R y_{k−1} + τ M (v_{k−1} + j/τ) + τ²/2 (f_k + s W u_k)
  right_hand_side(with.R(), in.from.y(), scheme.momentum(), momentum, scheme.impulse(), in.load, work);
  subtract_branch_forces(scheme, in.from, work);
  if (moving_clamps_)
    moving_clamps_->apply(*work.moving_clamps, with.whole_D(), clamped_, with.clamped_diagonal, work.r);
  // (4.21): D y_k + N λ_k = r, 0 ≤ λ_k ⊥ g(y_k) ≥ 0
  if (frictional()) {
    set_slip_gaps(in, psi, work);
    psi = work.slip_gaps;
    pairs_->friction(in.step.end, scheme.impulse(), out.contact.friction);
    pairs_->rows().spread(in.previous, work.mu);
  }
  if (const contact::ContactStepSolver* solver = contact_solver(with, work)) {
    const contact::ContactProblem problem{work.r, psi, in.previous.active, out.contact, out.to.y(), work.mu};
    try {
      solver->solve(problem, *work.contact);
    } catch (const contact::LawFailure& failure) {
      throw SolverFailure(described(failure));
    }
  } else
    with.solver->linear().solve(work.r, out.to.y());
  if (predictor_)
    predictor_->find_weak(out.contact, jump != nullptr, normal_psi, in.from.y(), in.previous,
                          *work.predictor);
  set_velocity(scheme, in.from, jump, out.to); // (4.22)
  set_branches(scheme, in.from, out.to);
  if (moving_clamps_)
    moving_clamps_->copy(work.moving_clamps->velocity, out.to.v());
  extrapolate(out.to.v(), work.moved);
  PetscReal size = 0;
  check(VecNorm(out.to.v(), NORM_2, &size));
  if (!std::isfinite(size))
    throw SolverFailure("the solution is not finite");
  ++steps;
}

const contact::ContactStepSolver* Stepper::contact_solver(const StepOperators::PerStepLength& with,
                                                          Workspace& work) const {
  const contact::ContactStepSolver* solver = with.solver->contact();
  if (solver && std::exchange(work.tau, with.tau) != with.tau)
    work.contact->forget();
  return solver;
}

void Stepper::solve_on_active_set(double tau, Direction direction,
                                  const contact::ContactLinearisation& contact, std::span<const double> value,
                                  Vec x, std::span<double> multipliers, Workspace& work,
                                  std::span<const double> law, std::span<double> law_duals) const {
  const StepOperators::PerStepLength& with = of_length(tau);
  if (const contact::ContactStepSolver* solver = contact_solver(with, work)) {
    const contact::LinearisedContact step{work.r, contact.active, contact.equations, value, x, multipliers,
                                          law,    law_duals};
    if (direction == Direction::linearised)
      solver->solve_linearised(step, *work.contact);
    else
      solver->solve_transposed(step, *work.contact);
  } else {
    with.solver->linear().solve(work.r, x);
  }
}

void Stepper::solve_one_sided(const Scheme& scheme, contact::ContactLinearisation& contact, Vec p,
                              Workspace& work) const {
  const contact::ConstraintRows& rows = pairs_->rows();
  const auto m = static_cast<std::size_t>(pairs_->count());
  std::vector<double> force(m), motion(m), lambda(m);
  rows.spread(contact, lambda);
  contact::close_to_first_order(rows, contact.weak, contact.active, force, motion, [&] {
    solve_on_active_set(scheme.tau, Direction::linearised, contact, {}, p, force, work);
    rows.apply_transpose(p, motion);
    PetscReal largest_force = 0, largest_motion = 0;
    check(VecNorm(work.r, NORM_INFINITY, &largest_force));
    check(VecNorm(p, NORM_INFINITY, &largest_motion));
    return std::pair(largest_force, largest_motion);
  });
  contact.forces.clear();
  for (const int i : contact.active)
    contact.forces.push_back(lambda[i]);
}

Vec Stepper::linearised_right_hand_side(const LinearisedStep& step,
                                        const contact::ContactLinearisation& contact, Workspace& work) const {
  const Scheme scheme = step.scheme;
  const Vec jump =
      predictor_ ? predictor_->linearised_jump(contact.predictor, predicted(scheme, step.from, work.work),
                                               *work.predictor, step.predictor)
                 : nullptr;
  right_hand_side(of_length(scheme.tau).R(), step.from.y(), scheme.momentum(),
                  with_jump(step.from.v(), scheme.jump_rate(), jump, work.moved), scheme.impulse(), step.load,
                  work);
  subtract_branch_forces(scheme, step.from, work);
  return jump;
}

void Stepper::linearised_step(const LinearisedStep& step, const contact::ContactLinearisation& contact,
                              Workspace& work) const {
  const Vec jump = linearised_right_hand_side(step, contact, work);
  solve_on_active_set(step.scheme.tau, Direction::linearised, contact,
                      with_slip(step.normal, step.from, work), step.to.y(), step.multipliers, work, step.law);
  set_velocity(step.scheme, step.from, jump, step.to);
  extrapolate(step.to.v(), work.moved);
  set_branches(step.scheme, step.from, step.to);
  ++linearised_steps;
}

void Stepper::one_sided_step(const LinearisedStep& step, contact::ContactLinearisation& contact,
                             Workspace& work) const {
  if (contact.kinks() == 0)
    return linearised_step(step, contact, work);
  if (!contact.predictor_weak.empty()) // afterwards Z has those that stay closed
    (void)predictor_->one_sided_jump(contact.predictor, contact.predictor_weak,
                                     predicted(step.scheme, step.from, work.work), *work.predictor);
  const Vec jump = linearised_right_hand_side(step, contact, work);
  if (frictional())
    solve_one_sided_slip(step, contact, work);
  else
    solve_one_sided(step.scheme, contact, step.to.y(), work);
  set_velocity(step.scheme, step.from, jump, step.to);
  extrapolate(step.to.v(), work.moved);
  set_branches(step.scheme, step.from, step.to);
  ++linearised_steps;
}

} // namespace signorini::step
