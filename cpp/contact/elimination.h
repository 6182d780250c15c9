// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "contact/workspace.h"
#include "linalg/sparse_cholesky.h"

namespace signorini::contact {

/// A solve with D in two halves, between which the contact forces are found (docs/method.md section 5):
/// predict() gives the motion without contact at the candidates, finish() completes the solve with the
/// contact forces.
class Elimination {
public:
  virtual ~Elimination() = default;

  /// Storage for predict(). Collective.
  [[nodiscard]] virtual Prediction prediction() const = 0;

  /// First half for the right-hand side r: `motion` (m) becomes Hᵀ D⁻¹r. Collective.
  virtual void predict(Vec r, Prediction& prediction, std::span<double> motion) const = 0;

  /// Second half: y = D⁻¹ (r − Hλ); may be repeated with other λ (m). Of `prediction` only scratch changes.
  /// Collective.
  virtual void finish(Prediction& prediction, std::span<const double> lambda, Vec y) const = 0;

  /// S = Hᵀ D⁻¹ H (m × m), the same on every rank. Collective.
  [[nodiscard]] virtual std::vector<double> condensed() const = 0;

  /// Memory beyond that of D's factor on all ranks, bytes. Collective.
  [[nodiscard]] virtual double bytes() const = 0;
};

/// Uses a Cholesky factor with the candidates last in the elimination order: contact involves only the last
/// diagonal block of the factor (its corner), and a step with contact takes one solve, as one without.
class TrailingBlockElimination final : public Elimination {
public:
  /// The corner of `D` must be the rows' dofs, in their order. The arguments must outlive this object.
  TrailingBlockElimination(const ConstraintRows& rows, const SparseCholesky& D);

  [[nodiscard]] Prediction prediction() const override;
  void predict(Vec r, Prediction& prediction, std::span<double> motion) const override;
  void finish(Prediction& prediction, std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] std::vector<double> condensed() const override;
  [[nodiscard]] double bytes() const override;

private:
  const ConstraintRows& rows_;
  const SparseCholesky& D_;
  std::vector<double> L_; ///< corner of the factor (c × c)
};

/// Works on any number of ranks. The columns of D⁻¹H, solved for in blocks, are stored if they fit into
/// `memory` (bytes, on all ranks); if not, a step with contact takes a second solve.
class StoredColumnsElimination final : public Elimination {
public:
  /// Solves with D for each candidate; `layout` is a vector of V. Collective. The references must outlive
  /// this object. Throws Interrupted, SolverFailure.
  StoredColumnsElimination(const ConstraintRows& rows, const MumpsSolver& D, Vec layout, double memory);

  [[nodiscard]] Prediction prediction() const override;
  void predict(Vec r, Prediction& prediction, std::span<double> motion) const override;
  void finish(Prediction& prediction, std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] std::vector<double> condensed() const override { return S_; }
  [[nodiscard]] double bytes() const override;

private:
  const ConstraintRows& rows_;
  const MumpsSolver& D_;
  std::vector<double> S_;
  petsc::Vector layout_;
  petsc::Series columns_; ///< D⁻¹H; empty where they do not fit
};

} // namespace signorini::contact
