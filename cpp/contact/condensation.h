// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "linalg/conjugate_gradients.h"
#include "linalg/mumps_solver.h"
#include "linalg/sparse_cholesky.h"

namespace signorini::contact {

/// The first half of a solve with D for a right-hand side r (Condensation::predict()), from which the second
/// half goes on, any number of times. Which vectors are there depends on the condensation.
struct HalfSolve {
  std::vector<double> z;         ///< L⁻¹Pr, by trailing block (n)
  petsc::Vector r, y;            ///< r and D⁻¹r, by columns of D⁻¹H
  std::vector<double> reference; ///< multipliers λ with y = D⁻¹(r − Hλ), by columns: zero but on demand
  // Scratch of either half.
  std::vector<double> trailing_block; ///< by trailing block (c)
  std::vector<double> weights;
  std::vector<Vec> columns;
  petsc::Vector forces;
};

/// A guess of a solution y, with the groups that are active in it.
struct Guess {
  Vec y;
  std::span<const int> active;
};

/// A solve with D in two halves, between which the contact forces are found (docs/method.md section 5):
/// predict() gives the motion without contact at the candidates, finish() completes the solve with the
/// contact forces. Arrays have an entry for each row of H.
class Condensation {
public:
  virtual ~Condensation() = default;

  /// Storage for predict(). Collective.
  [[nodiscard]] virtual HalfSolve half_solve() const = 0;

  /// First half for the right-hand side r: `motion` becomes Hᵀ D⁻¹r. Direct solvers ignore the guess.
  /// Collective. Throws SolverFailure.
  virtual void predict(Vec r, const Guess& guess, HalfSolve& half_solve, std::span<double> motion) const = 0;

  /// Second half: y = D⁻¹ (r − Hλ), with a guess on entry; may be repeated with other λ. Of `half_solve` only
  /// scratch changes.
  /// Collective. Throws SolverFailure.
  virtual void finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const = 0;

  /// Whether all columns of S = Hᵀ D⁻¹ H are known. If not, column() is for rows that were prepared.
  [[nodiscard]] virtual bool complete() const = 0;
  /// Computes columns of S that are not known yet. Collective. Throws SolverFailure.
  virtual void prepare(std::span<const int> rows) const = 0;
  /// S_·row, the same on every rank.
  [[nodiscard]] virtual std::span<const double> column(int row) const = 0;

  /// Memory beyond that of D's factor on all ranks, bytes. Collective.
  [[nodiscard]] virtual double bytes() const = 0;
};

/// A condensation that computes S when it is set up.
class WholeCondensation : public Condensation {
public:
  [[nodiscard]] bool complete() const final { return true; }
  void prepare(std::span<const int>) const final {}
  [[nodiscard]] std::span<const double> column(int row) const final {
    const auto m = static_cast<std::size_t>(rows_.count());
    return std::span(S_).subspan(static_cast<std::size_t>(row) * m, m);
  }

protected:
  explicit WholeCondensation(const ConstraintRows& rows) : rows_(rows) {}
  const ConstraintRows& rows_;
  std::vector<double> S_; ///< symmetric
};

/// Uses a Cholesky factor with the candidates last in the elimination order: contact involves only the last
/// diagonal block of the factor (its trailing block), and a step with contact takes one solve, as one
/// without.
class TrailingBlockCondensation final : public WholeCondensation {
public:
  /// The trailing block of `D` must be the rows' dofs, in their order. The arguments must outlive this
  /// object.
  TrailingBlockCondensation(const ConstraintRows& rows, const SparseCholesky& D);

  [[nodiscard]] HalfSolve half_solve() const override;
  void predict(Vec r, const Guess&, HalfSolve& half_solve, std::span<double> motion) const override;
  void finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] double bytes() const override;

private:
  /// S from the trailing block.
  void condense();

  const SparseCholesky& D_;
  std::vector<double> L_; ///< trailing block of the factor (c × c)
};

/// Works on any number of ranks. The columns of D⁻¹H, solved for in blocks, are stored if they fit into
/// `memory` (bytes, on all ranks); if not, a step with contact takes a second solve.
class StoredColumnsCondensation final : public WholeCondensation {
public:
  /// Solves with D for each candidate; `layout` is a vector of V. Collective. The references must outlive
  /// this object. Throws Interrupted, SolverFailure.
  StoredColumnsCondensation(const ConstraintRows& rows, const MumpsSolver& D, Vec layout, double memory);

  [[nodiscard]] HalfSolve half_solve() const override;
  void predict(Vec r, const Guess&, HalfSolve& half_solve, std::span<double> motion) const override;
  void finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] double bytes() const override;

private:
  const MumpsSolver& D_;
  petsc::Vector layout_;
  petsc::Series columns_; ///< D⁻¹H, all null where they do not fit
};

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
  [[nodiscard]] std::span<const double> column(int row) const override { return S_[row]; }
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
