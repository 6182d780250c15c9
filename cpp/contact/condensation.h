// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "linalg/conjugate_gradients.h"
#include "linalg/mumps_solver.h"
#include "linalg/sparse_cholesky.h"

namespace signorini::contact {

/// First half of a solve with D for a right-hand side r (Condensation::predict()); the second half continues
/// from it, any number of times. The condensation determines which vectors are allocated.
struct HalfSolve {
  std::vector<double> z;         ///< L⁻¹Pr (n); TrailingBlockCondensation only
  petsc::Vector r, y;            ///< r and D⁻¹r; condensations with columns of D⁻¹H
  std::vector<double> reference; ///< multipliers λ with y = D⁻¹(r − Hλ); nonzero in ColumnsOnDemand only
  // Scratch of either half.
  std::vector<double> trailing_block; ///< values at the trailing block's dofs (c)
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

  /// Second half: y = D⁻¹ (r − Hλ), with a guess on entry; may be repeated with other λ. Changes only the
  /// scratch of `half_solve`.
  /// Collective. Throws SolverFailure.
  virtual void finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const = 0;

  /// Whether all columns of S = Hᵀ D⁻¹ H are known. If not, prepare() must precede column().
  [[nodiscard]] virtual bool complete() const = 0;
  /// Computes columns of S that are not known yet. Collective. Throws SolverFailure.
  virtual void prepare(std::span<const int> rows) const = 0;
  /// Column S_·row, the same on every rank.
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
/// diagonal block of the factor (its trailing block), and a step takes one solve, with contact or
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
  /// Computes S from the trailing block.
  void condense();

  const SparseCholesky& D_;
  std::vector<double> L_; ///< trailing block of the factor (c × c)
};

/// Condensation by the columns of D⁻¹H, on any number of ranks. They are solved for in blocks, and stored if
/// they fit into `memory` (bytes, on all ranks); if not, a step with contact takes a second solve.
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
  petsc::Series columns_; ///< columns of D⁻¹H, all null if they do not fit
};

/// Condensation by conjugate gradients, on any number of ranks. A row of H costs one solve when it first
/// closes. Its column of S is kept for as long as D, its column of D⁻¹H if it fits into `memory` (bytes, on
/// all ranks). A step with contact then takes one solve, or two if a column is not kept.
class ColumnsOnDemand final : public Condensation {
public:
  /// `matrix` is D. Collective. The references must outlive this object.
  ColumnsOnDemand(const ConstraintRows& rows, const ConjugateGradients& D, Mat matrix, double memory);

  [[nodiscard]] HalfSolve half_solve() const override;
  /// Solves D y = r − Hρ from the guess, with the guess's multipliers ρ on its active groups.
  void predict(Vec r, const Guess& guess, HalfSolve& half_solve, std::span<double> motion) const override;
  void finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] bool complete() const override { return false; }
  /// Throws Interrupted, SolverFailure.
  void prepare(std::span<const int> rows) const override;
  [[nodiscard]] std::span<const double> column(int row) const override { return S_[row]; }
  /// Memory of the columns computed so far, on all ranks, bytes.
  [[nodiscard]] double bytes() const override;

private:
  const ConstraintRows& rows_;
  const ConjugateGradients& D_;
  Mat matrix_;
  double memory_;
  petsc::Vector diagonal_; ///< diagonal of D if components of candidates' nodes are clamped, else null
  // Rows that close become known only in the steps; each is solved for once.
  mutable std::vector<std::vector<double>> S_; ///< columns of S, empty where not known yet
  mutable petsc::Series columns_;              ///< columns of D⁻¹H, null where not known or not kept
  mutable double kept_ = 0;                    ///< memory of columns_, bytes
};

} // namespace signorini::contact
