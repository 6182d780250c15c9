// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fixtures.h"
#include <algorithm>

namespace signorini::test {

/// The body of a scene with its matrices, foundations included.
struct Body {
  scene::Scene scene;
  std::shared_ptr<const problem::SpaceDiscretisation> shared;
  fem::Space space;
  fem::Operators operators;
  Body(const char* file, int degree, const std::vector<std::string>& overrides)
      : scene(parse(source(file), overrides)), shared(discretised(scene)), space(shared->mesh, degree),
        operators(fem::assemble_operators(space, scene.materials, true, scene.foundations)) {}

  [[nodiscard]] petsc::Vector field(const scene::Components& components) const {
    petsc::Vector x = space.vector();
    space.interpolate(scene::Field(components, "test", false), 0, x);
    return x;
  }
};

/// x·matrix·x.
inline double energy(Mat matrix, Vec x) {
  const petsc::Vector product = petsc::zero_like(x);
  petsc::check(MatMult(matrix, x, product));
  return petsc::dot(x, product);
}

/// Largest residuals of the energy law and the momentum law of a motion, its energies relative to the
/// largest, and the number of steps with contact.
struct Laws {
  double energy = 0, momentum = 0, foundation = 0, dashpots = 0, drag = 0, branches = 0, relaxed = 0;
  double least_relaxed = 0; ///< least energy that branches lose in a step; not negative beyond rounding
  int touched = 0;

  explicit Laws(const Recorded& motion) {
    double most = 0;
    for (const diagnostics::StepBalance& step : motion.balance)
      most = std::max(most, step.energy());
    for (std::size_t k = 1; k < motion.balance.size(); ++k) {
      const diagnostics::StepBalance& step = motion.balance[k];
      energy = std::max(energy, std::abs(step.energy_residual) / most);
      momentum = std::max(momentum, diagnostics::length(step.momentum_residual) / step.momentum_scale);
      foundation = std::max(foundation, step.foundation_energy / most);
      branches = std::max(branches, step.relaxation_energy / most);
      dashpots += step.foundation_dissipation / most;
      drag += step.drag_dissipation / most;
      relaxed += step.relaxation_dissipation / most;
      least_relaxed = std::min(least_relaxed, step.relaxation_dissipation / most);
      touched += motion.contact[k].count(contact::Status::strong) > 0;
    }
  }
};

} // namespace signorini::test
