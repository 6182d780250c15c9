// SPDX-License-Identifier: GPL-3.0-or-later
#include "problem/static_start.h"
#include "base/error.h"
#include "diagnostics/body_figures.h"
#include "step/functionals.h"
#include "step/scheme.h"
#include "step/solver_choice.h"
#include <cmath>
#include <utility>

namespace signorini::problem {
using petsc::check;

namespace {

/// Steps so long that inertia is negligible beside stiffness: D y' + N λ = (D − s A) y + s f, with s = τ²/4,
/// where D is that of a body without damping. Their limit is the equilibrium; where nothing holds the body,
/// it moves by s a in each.
class LongSteps {
public:
  LongSteps(const step::Stepper& stepper, const fem::Operators& operators, const scene::Scene& scene,
            const contact::ContactPairs* pairs, double tau)
      : stepper_(stepper), operators_(operators), pairs_(pairs), stiffness_(step::Scheme{tau}.stiffness()),
        product_(stepper.space().vector()), r_(stepper.space().vector()) {
    std::vector<scene::Material> elastic = scene.materials; // damping would slow the approach
    for (scene::Material& material : elastic) {
      material.viscosity.reset();
      material.rayleigh.reset();
    }
    petsc::Matrix D = fem::assemble_step_operator(stepper.space(), elastic, tau);
    operators.add_surroundings(D, tau);
    rest_ = fem::shifted(operators.A, D, stiffness_); // D − s A
    stepper.clamped().decouple(D);
    fem::attach_rigid_motions(D, stepper.space());
    constexpr double few = 20; // solves
    solver_.emplace(std::move(D), pairs, scene.solver, false, few);
    if (pairs_) {
      contact_ = contact::ContactState(pairs_->count(), pairs_->rows().count());
      psi_.resize(static_cast<std::size_t>(pairs_->rows().count()));
      work_.emplace(solver_->contact()->workspace());
    }
  }

  /// Acceleration of unit displacement of a step, 1/s².
  [[nodiscard]] double acceleration() const { return 1 / stiffness_; }

  /// Changes y by a step under the forces f − M a; y has `held` on clamped dofs.
  void advance(Vec f, Vec held, Vec y) {
    // for the part y − held, which is zero on clamped dofs
    check(VecAXPY(y, -1, held));
    check(MatMult(rest_, y, r_));
    check(VecAXPY(r_, stiffness_, f));
    check(MatMult(operators_.A, held, product_));
    check(VecAXPY(r_, -stiffness_, product_));
    stepper_.clamped().clear(r_);
    if (pairs_) {
      pairs_->rows().gap(pairs_->psi(), held, psi_);
      const contact::ActiveSet previous = contact_.active;
      solver_->contact()->solve({r_, psi_, previous, contact_, y}, *work_);
    } else {
      solver_->linear().solve(r_, y);
    }
    check(VecAXPY(y, 1, held));
  }

  /// Closes the gaps of candidates in contact up to rounding of y itself.
  void close(Vec y) const {
    if (pairs_)
      pairs_->rows().prescribe(contact_.active, pairs_->psi(), y);
  }

private:
  const step::Stepper& stepper_;
  const fem::Operators& operators_;
  const contact::ContactPairs* pairs_;
  double stiffness_;
  petsc::Matrix rest_;
  petsc::Vector product_, r_;
  std::optional<step::SolverChoice> solver_;
  contact::ContactState contact_;
  std::vector<double> psi_;
  std::optional<contact::Workspace> work_;
};

double largest(Vec x) {
  PetscReal size = 0;
  check(VecNorm(x, NORM_INFINITY, &size));
  return size;
}

/// A translation of the body, its product with the mass matrix, and the mean motion along it.
struct Translation {
  petsc::Vector unit, inertia;
  step::Mean mean;
};

std::vector<Translation> translations_of(const step::Stepper& stepper) {
  std::vector<Translation> all;
  for (std::size_t c = 0; c < static_cast<std::size_t>(stepper.space().dim()); ++c)
    if (stepper.space().translates(c)) {
      all.push_back({step::translation(stepper.space(), c), stepper.space().vector(),
                     step::mean(stepper.space(), stepper.M(), c)});
      check(MatMult(stepper.M(), all.back().unit, all.back().inertia));
    }
  return all;
}

/// Forces at t = 0.
petsc::Vector forces(const step::Stepper& stepper, const fem::Operators& operators,
                     const step::SceneLoad* load) {
  petsc::Vector f = stepper.space().vector();
  if (!load)
    return f;
  const step::ForceAtStep at(stepper.space(), {load});
  constexpr double instant = 1e-9; // part of a step
  const double tau = instant * stepper.first_length();
  assemble(at.at({1, 0, tau, tau}), operators, f);
  return f;
}

} // namespace

void start_in_equilibrium(const step::Stepper& stepper, const fem::Operators& operators,
                          const scene::Scene& scene, const step::SceneLoad* load, Vec y) {
  std::optional<contact::ContactPairs> pairs;
  if (stepper.pairs())
    pairs.emplace(stepper.space(), stepper.clamped(), contact::without_friction(scene.contacts), scene.time);
  constexpr double long_step = 100; // in crossings of a wave
  LongSteps steps(stepper, operators, scene, pairs ? &*pairs : nullptr,
                  long_step * diagnostics::body_figures(stepper, scene).crossing);
  const petsc::Vector held = petsc::copy(y), f = forces(stepper, operators, load);
  petsc::Vector before = petsc::zero_like(y), change = petsc::zero_like(y), last = petsc::zero_like(y);
  const std::vector<Translation> translations = translations_of(stepper);
  double first = 0; // acceleration without any support
  for (const Translation& along : translations)
    first = std::hypot(first, petsc::dot(along.unit, f) / along.mean.measure);
  // The solves leave rounding errors along directions in which nothing holds the body, of 1e-13 to 1e-11 of
  // the motion there under the whole load: an acceleration that is negligible.
  constexpr int corrections = 6, most = 100;
  constexpr double exact = 1e-14, negligible = 1e-10, steady = 1e-2;
  const double unit = (first + largest(held) * steps.acceleration()) / steps.acceleration();
  for (int correction = 0; correction < corrections; ++correction) {
    check(VecCopy(held, y));
    double size = 0;
    for (int i = 0; i < most; ++i) {
      check(VecCopy(y, before));
      check(VecCopy(change, last));
      steps.advance(f, held, y);
      check(VecWAXPY(change, -1, before, y));
      const double previous = std::exchange(size, largest(change));
      const bool falls = i == 0 || size < previous / 2;
      if (size <= exact * unit || (size <= negligible * unit && !falls))
        return steps.close(y);
      check(VecAXPY(last, -1, change));
      if (i > 2 && largest(last) <= steady * size)
        break;
    }
    for (const Translation& along : translations) {
      const double moved = petsc::dot(along.mean.weights, change);
      check(VecAXPY(change, -moved, along.unit));
      check(VecAXPY(f, -moved * steps.acceleration(), along.inertia));
    }
    if (largest(change) > steady * size)
      break; // it turns, or does not come to rest
  }
  throw UserError(
      "initial.static: found loads at t = 0 under which the body turns or leaves its supports; hold it by "
      "clamps, obstacles or foundations, or remove initial.static");
}

} // namespace signorini::problem
