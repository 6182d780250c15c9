// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/linear_solver.h"

namespace signorini {

/// Direct solver by MUMPS, on any number of ranks. PETSc options with the prefix `-step_` are honoured.
class MumpsSolver final : public LinearSolver {
public:
  /// Copies `matrix` and analyses the copy, which gives the elimination order and estimates of memory and
  /// work. Collective. Throws SolverFailure.
  explicit MumpsSolver(Mat matrix);

  /// Whether MUMPS can index the factor's entries: always true, since it uses 64-bit indices.
  [[nodiscard]] static bool indexable() { return true; }

  /// Memory that the factorisation will take on all ranks, as the analysis estimates it, bytes. Collective.
  [[nodiscard]] double estimate() const;

  /// Work of the factorisation, as the analysis estimates it. Collective.
  [[nodiscard]] FactorWork work() const;

  /// Computes the factor. Call this once, before solve(). Collective. Throws SolverFailure.
  void factorise();

  void solve(Vec b, Vec x) const override;

  /// Solves A X = B, with the factorised matrix A, for a sparse B and returns X, dense (n × k). `transposed`:
  /// Bᵀ (k × n) in AIJ format, with all of its rows and columns on rank 0. Collective. Throws SolverFailure.
  [[nodiscard]] petsc::Matrix solve_sparse(Mat transposed) const;

  [[nodiscard]] std::string name() const override { return "MUMPS"; }
  [[nodiscard]] double bytes() const override;

private:
  void analyse();
  [[nodiscard]] bool short_of_space() const;
  petsc::Matrix matrix_, factor_;
};

} // namespace signorini
