// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/lcp/goldfarb_idnani.h"
#include "contact/lcp/snes_vi.h"
#include <memory>
#include <optional>

namespace signorini::contact {

/// The first half of a solve with D for a right-hand side r (Condensation::predict()), from which the second
/// half goes on, any number of times. Which vectors are there depends on the condensation.
struct HalfSolve {
  std::vector<double> z;         ///< L⁻¹Pr, by trailing block (n)
  petsc::Vector r, y;            ///< r and D⁻¹r, by columns of D⁻¹H
  std::vector<double> reference; ///< multipliers λ with y = D⁻¹(r − Hλ), by columns on demand
  // Scratch of either half.
  std::vector<double> trailing_block; ///< by trailing block (c)
  std::vector<double> weights;
  std::vector<Vec> columns;
  petsc::Vector forces;
};

/// PETSc's VI solver of a condensed step: 0 ≤ g ⟂ K (g − g⁰) ≥ 0 with K = S⁻¹, scaled to a mean diagonal of
/// one.
struct CondensedVi {
  petsc::Matrix K;
  petsc::Vector x, gap0, constant;
  std::optional<SnesVi> vi;
};

/// Scratch of the solvers of contact steps, made by ContactStepSolver::workspace(); each uses some of it. No
/// call depends on what an earlier one left, except that the factor of S_AA is used again for the same set,
/// and K in `condensed`: both belong to one D. One at a time may work with it.
struct Workspace {
  /// For so many rows of constraints.
  explicit Workspace(int rows) : gap0(static_cast<std::size_t>(rows)), motion(gap0.size()), mu(gap0.size()) {
    for (ActiveSet* one : {&set, &next, &wrong, &factorised, &independent})
      one->reserve(gap0.size());
    b.reserve(gap0.size());
  }

  /// To be called before steps with another D.
  void forget() {
    factorised.clear();
    factor.clear();
    condensed.reset();
  }

  HalfSolve half_solve;
  std::vector<double> gap0;           ///< predicted gaps (m), of rows as those below
  ActiveSet set, next, wrong;         ///< that of an iterate, the one after it, where they differ
  ActiveSet factorised, independent;  ///< the set of `factor`; the independent part of a set
  std::vector<double> factor;         ///< Cholesky factor of S_AA
  std::vector<double> motion, mu;     ///< Hᵀy; multipliers of a linearised step
  std::vector<double> b;              ///< right-hand side on a set
  std::vector<LawEquation> equations; ///< of the set, where laws are not symmetric
  petsc::Vector residual, correction; ///< made when a solution is first refined
  GoldfarbIdnaniWork dual;
  std::unique_ptr<CondensedVi> condensed; ///< made when it is first needed
};

} // namespace signorini::contact
