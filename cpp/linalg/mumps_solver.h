// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/linear_solver.h"

namespace signorini {

/// Factorisation by MUMPS on any number of ranks. PETSc options with the prefix `-step_` are honoured.
class MumpsSolver final : public LinearSolver {
public:
  /// Analyses a copy of `matrix`: elimination order and memory. Collective. Throws SolverFailure.
  explicit MumpsSolver(Mat matrix);

  /// Whether the factor's entries can be indexed; always, since MUMPS uses 64-bit indices.
  [[nodiscard]] static bool possible() { return true; }

  /// Memory of the factorisation on all ranks as estimated by the analysis, bytes. Collective.
  [[nodiscard]] double estimate() const;

  /// Work of the factorisation as estimated by the analysis. Collective.
  [[nodiscard]] FactorWork work() const;

  /// Computes the factor; to be called once before solve(). Collective. Throws SolverFailure.
  void factorise();

  void solve(Vec b, Vec x) const override;

  /// X = matrix⁻¹ B, dense (n × k), for a sparse B, which MUMPS takes from rank 0: `transposed` is Bᵀ (k ×
  /// n), AIJ with all of its rows and columns there. Collective. Throws SolverFailure.
  [[nodiscard]] petsc::Matrix solve_sparse(Mat transposed) const;

  [[nodiscard]] std::string name() const override { return "MUMPS"; }
  [[nodiscard]] double bytes() const override;

private:
  void analyse();
  [[nodiscard]] bool short_of_space() const;
  petsc::Matrix matrix_, factor_;
};

} // namespace signorini
