// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/condensation.h"
#include "linalg/linear_solver.h"

namespace signorini::contact {

/// Condensation by conjugate gradients, on any number of ranks. A row of H costs one solve when it first
/// closes; its column of S is kept for as long as D, and that of D⁻¹H while `memory` (bytes, on all ranks)
/// lasts. A step with contact then takes one solve, or two where a column is not kept.
class ColumnsOnDemand final : public Condensation {
public:
  /// `matrix` is D. Collective. The references must outlive this object.
  ColumnsOnDemand(const ConstraintRows& rows, const ConjugateGradients& D, Mat matrix, double memory);

  [[nodiscard]] HalfSolve half_solve() const override;
  /// Solves D y = r − Hρ from the guess, for the multipliers ρ that it has on its active groups.
  void predict(Vec r, const Guess& guess, HalfSolve& half_solve, std::span<double> motion) const override;
  void finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] bool complete() const override { return false; }
  /// Throws Interrupted, SolverFailure.
  void prepare(std::span<const int> rows) const override;
  [[nodiscard]] std::span<const double> column(int row) const override {
    return S_[static_cast<std::size_t>(row)];
  }
  /// Of the columns so far.
  [[nodiscard]] double bytes() const override;

private:
  const ConstraintRows& rows_;
  const ConjugateGradients& D_;
  Mat matrix_;
  double memory_;
  petsc::Vector diagonal_; ///< of D where clamps hold components of candidates' nodes, else null
  // Which rows close is known only in the steps, and each is solved for once.
  mutable std::vector<std::vector<double>> S_; ///< columns, empty where not known yet
  mutable petsc::Series columns_;              ///< of D⁻¹H, null where not known or not kept
  mutable double kept_ = 0;                    ///< bytes of these
};

} // namespace signorini::contact
