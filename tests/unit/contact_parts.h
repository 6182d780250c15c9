// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"
#include "fixtures.h"
#include "step/solver_choice.h"

namespace signorini::test {

/// The parts of a contact step on their own.
struct Parts {
  scene::Scene scene;
  std::shared_ptr<const problem::SpaceDiscretisation> shared;
  fem::Space space;
  fem::DirichletDofs clamped;
  petsc::Matrix D;
  contact::ContactPairs pairs;
  const contact::ConstraintRows& H = pairs.rows();
  step::SolverChoice solver;

  /// `solves`: expected.
  explicit Parts(const std::vector<std::string>& overrides = {}, double solves = 0,
                 const char* file = "tests/data/block.toml")
      : scene(parse(source(file), overrides)), shared(discretised(scene)),
        space(shared->mesh, scene.mesh.degree), clamped(space, scene.clamps),
        D(fem::assemble_step_operator(space, scene.materials, scene.time.step)),
        pairs(space, clamped, scene.contacts), solver(copy(D), &pairs, scene.solver, true, solves) {}

  static petsc::Matrix copy(Mat matrix) {
    petsc::Matrix same;
    petsc::check(MatDuplicate(matrix, MAT_COPY_VALUES, same.put()));
    return same;
  }

  /// The contact step for r from a previous state (default: all open), y from zero.
  contact::ContactState solve(Vec r, Vec y) const {
    return solve(r, contact::ContactState(pairs.count()), y);
  }
  contact::ContactState solve(Vec r, const contact::ContactState& previous, Vec y) const {
    contact::ContactState state(pairs.count());
    contact::Workspace work = solver.contact()->workspace();
    const contact::ContactProblem step{r, pairs.psi(), previous.active, state, y};
    solver.contact()->solve(step, work);
    return state;
  }

  /// r = D y for a target y that presses some candidates into the obstacle and lifts others.
  petsc::Vector pressing(int which) const {
    petsc::Vector y = smooth(space, which), r = petsc::zero_like(y);
    petsc::check(VecScale(y, 0.5));
    petsc::check(VecShift(y, -0.4));
    petsc::check(MatMult(D, y, r));
    return r;
  }
};

} // namespace signorini::test
