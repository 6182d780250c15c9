// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "linalg/conjugate_gradients.h"
#include "linalg/mumps_solver.h"
#include "linalg/sparse_cholesky.h"

namespace signorini::contact {

/// Result of the first half of a solve with D for a right-hand side r, from Condensation::predict(). The
/// second half, finish(), may continue from it any number of times. Which vectors are allocated depends on
/// the type of the condensation.
struct HalfSolve {
  SparseCholesky::Forward z;     ///< forward solution for r; used by TrailingBlockCondensation only
  petsc::Vector r, y;            ///< r and D⁻¹(r − Hρ); not used by TrailingBlockCondensation
  std::vector<double> reference; ///< multipliers ρ with which y was computed; zero except in ColumnsOnDemand
  // Scratch of both halves.
  std::vector<double> trailing_block; ///< one value for each dof of the trailing block
  std::vector<double> weights;
  std::vector<Vec> columns;
  petsc::Vector forces;
};

/// Guess of the solution y of a solve, with the groups that are active in this guess.
struct Guess {
  Vec y;
  std::span<const int> active;
};

/// Solves systems with D in two halves, between which the contact forces are computed (docs/method.md section
/// 5). predict() computes the motion without contact forces at the candidates; finish() completes the solve
/// with the contact forces. Arrays have one entry for each row of H.
class Condensation {
public:
  virtual ~Condensation() = default;

  /// Allocates the storage for predict(). Collective.
  [[nodiscard]] virtual HalfSolve half_solve() const = 0;

  /// First half of the solve for the right-hand side r. Sets `motion` to Hᵀ D⁻¹r. Iterative solvers start
  /// from the guess, direct solvers ignore it. Collective. Throws SolverFailure, Interrupted.
  virtual void predict(Vec r, const Guess& guess, HalfSolve& half_solve, std::span<double> motion) const = 0;

  /// Second half of the solve: computes y = D⁻¹ (r − Hλ). On entry y contains a guess. The call may be
  /// repeated with other λ and changes only the scratch of `half_solve`. Collective. Throws SolverFailure.
  virtual void finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const = 0;

  /// Whether all columns of S = Hᵀ D⁻¹ H have been computed. If not, call prepare() before column().
  [[nodiscard]] virtual bool complete() const = 0;
  /// Computes those columns of S for the given rows of H that have not been computed yet. Collective. Throws
  /// SolverFailure, Interrupted.
  virtual void prepare(std::span<const int> rows) const = 0;
  /// Column of S that belongs to a row of H, the same on every rank.
  [[nodiscard]] virtual std::span<const double> column(int row) const = 0;

  /// Memory on all ranks in addition to D's factor, bytes. Collective.
  [[nodiscard]] virtual double bytes() const = 0;
};

/// Condensation that computes all of S in its constructor.
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
  std::vector<double> S_; ///< S = Hᵀ D⁻¹ H (rows × rows), symmetric
};

/// Condensation by a Cholesky factor that has the candidates last in its elimination order. Contact then
/// involves only the last diagonal block of the factor (the trailing block), and each step takes one solve,
/// with or without contact.
class TrailingBlockCondensation final : public WholeCondensation {
public:
  /// The trailing block of `D` must consist of the dofs of `rows`, in their order. Both arguments must
  /// outlive this object.
  TrailingBlockCondensation(const ConstraintRows& rows, const SparseCholesky& D);

  [[nodiscard]] HalfSolve half_solve() const override;
  void predict(Vec r, const Guess&, HalfSolve& half_solve, std::span<double> motion) const override;
  void finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] double bytes() const override;

private:
  /// Computes S from the trailing block of the factor.
  void condense();

  const SparseCholesky& D_;
  std::vector<double> L_; ///< trailing block of the factor (c × c, for c constrained dofs)
};

/// Condensation by the columns of D⁻¹H, on any number of ranks. The columns are solved for in blocks. They
/// are stored if they fit into `memory` (bytes, on all ranks); otherwise a step with contact takes a second
/// solve.
class StoredColumnsCondensation final : public WholeCondensation {
public:
  /// Solves with D once for each row of H. `layout`: any vector of V. The references must outlive this
  /// object. Collective. Throws Interrupted, SolverFailure.
  StoredColumnsCondensation(const ConstraintRows& rows, const MumpsSolver& D, Vec layout, double memory);

  [[nodiscard]] HalfSolve half_solve() const override;
  void predict(Vec r, const Guess&, HalfSolve& half_solve, std::span<double> motion) const override;
  void finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] double bytes() const override;

private:
  const MumpsSolver& D_;
  petsc::Vector layout_;
  petsc::Series columns_; ///< columns of D⁻¹H; null if they do not fit into memory
};

/// Condensation by conjugate gradients, on any number of ranks. It solves for a column of D⁻¹H when the gap
/// of its row first closes, and keeps the corresponding column of S as long as this object exists. The column
/// of D⁻¹H is kept if it fits into `memory` (bytes, on all ranks). In addition to the solves for new columns,
/// a step with contact takes one solve, or two if a column of D⁻¹H that it needs was not kept.
class ColumnsOnDemand final : public Condensation {
public:
  /// `matrix`: the matrix D. The references must outlive this object. Collective.
  ColumnsOnDemand(const ConstraintRows& rows, const ConjugateGradients& D, Mat matrix, double memory);

  [[nodiscard]] HalfSolve half_solve() const override;
  /// Solves D y = r − Hρ from the guess, where ρ are the multipliers of the guess on its active groups.
  void predict(Vec r, const Guess& guess, HalfSolve& half_solve, std::span<double> motion) const override;
  void finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] bool complete() const override { return false; }
  /// Solves with D once for each new row. Throws Interrupted, SolverFailure.
  void prepare(std::span<const int> rows) const override;
  [[nodiscard]] std::span<const double> column(int row) const override { return S_[row]; }
  /// Memory of the columns that have been computed so far, on all ranks, bytes.
  [[nodiscard]] double bytes() const override;

private:
  const ConstraintRows& rows_;
  const ConjugateGradients& D_;
  Mat matrix_;
  double memory_;
  petsc::Vector diagonal_; ///< diagonal of D if a constrained dof is clamped, else null
  // Mutable: which rows close is found only during the steps. Each of these rows is solved for once.
  mutable std::vector<std::vector<double>> S_; ///< columns of S; empty if not computed yet
  mutable petsc::Series columns_;              ///< columns of D⁻¹H; null if not computed or not kept
  mutable double kept_ = 0;                    ///< memory of columns_ on all ranks, bytes
};

} // namespace signorini::contact
