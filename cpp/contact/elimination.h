#pragma once
#include "base/sparse_cholesky.h"
#include "contact/constraints.h"

namespace signorini::contact {

/// A solve with D in two halves, between which the contact forces are found (docs/method.md section 5):
/// predict() gives the motion without contact at the candidates, finish() completes the solve with the
/// contact forces.
class Elimination {
public:
  virtual ~Elimination() = default;

  /// First half for the right-hand side r: `normal` (m) becomes ν_i·D⁻¹r. Collective.
  virtual void predict(Vec r, std::span<double> normal) const = 0;

  /// Second half, for the r of the last predict(): y = D⁻¹ (r − Nλ); may be repeated with other λ (m).
  /// Collective.
  virtual void finish(std::span<const double> lambda, Vec y) const = 0;

  /// S = Nᵀ D⁻¹ N (m × m), the same on every rank. Collective.
  [[nodiscard]] virtual std::vector<double> condensed() const = 0;

  /// Memory beyond that of D's factor on all ranks, bytes. Collective.
  [[nodiscard]] virtual double bytes() const = 0;
};

/// Uses a Cholesky factor with the candidates last in the elimination order: contact involves only the last
/// diagonal block of the factor (its corner), and a step with contact takes one solve, as one without.
class TrailingBlockElimination final : public Elimination {
public:
  /// The corner of `D` must be the candidates' nodes, each once, in their order. The arguments must outlive
  /// this object.
  TrailingBlockElimination(const Constraints& constraints, const SparseCholesky& D);

  void predict(Vec r, std::span<double> normal) const override;
  void finish(std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] std::vector<double> condensed() const override;
  [[nodiscard]] double bytes() const override;

private:
  const Constraints& constraints_;
  const SparseCholesky& D_;
  std::vector<double> L_;                  ///< corner of the factor (c × c)
  mutable std::vector<double> z_, corner_; ///< corner after the last forward half; scratch (c)
};

/// Works with any solver of D. The columns of D⁻¹N are stored if they fit into `memory` (bytes, on all
/// ranks); if not, a step with contact takes a second solve.
class StoredColumnsElimination final : public Elimination {
public:
  /// Makes one solve per candidate; `layout` is a vector of V. Collective. The references must outlive this
  /// object. Throws Interrupted, SolverFailure.
  StoredColumnsElimination(const Constraints& constraints, const LinearSolver& D, Vec layout, double memory);

  void predict(Vec r, std::span<double> normal) const override;
  void finish(std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] std::vector<double> condensed() const override { return S_; }
  [[nodiscard]] double bytes() const override;

private:
  const Constraints& constraints_;
  const LinearSolver& D_;
  std::vector<double> S_;
  petsc::Series columns_; ///< D⁻¹N; empty where they do not fit
  petsc::Vector r_, y_;   ///< of the last prediction
  petsc::Vector work_;
  mutable std::vector<double> weights_;
  mutable std::vector<Vec> used_;
};

} // namespace signorini::contact
