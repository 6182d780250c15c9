#pragma once
#include "base/sparse_cholesky.h"
#include "contact/constraints.h"

namespace signorini::contact {

/// A solve with D in two halves, between which contact acts (docs/method.md section 5): the first predicts the
/// motion without contact at the candidates, the second ends the solve with the contact forces that this
/// called for.
class Elimination {
public:
  virtual ~Elimination() = default;

  /// First half for the right-hand side r: `normal` (m) becomes Nᵀ D⁻¹ r. Collective.
  virtual void predict(Vec r, std::span<double> normal) const = 0;

  /// Second half: y = D⁻¹ (r − Nλ); may be repeated with other forces. Collective.
  virtual void finish(std::span<const double> lambda, Vec y) const = 0;

  /// S = Nᵀ D⁻¹ N (m × m), the same on every rank. Collective.
  [[nodiscard]] virtual std::vector<double> condensed() const = 0;

  /// Memory beyond that of D's factor on all ranks, bytes. Collective.
  [[nodiscard]] virtual double bytes() const = 0;
};

/// By a factorisation with the candidates last: all of contact happens in its corner, and a step with contact
/// takes one solve like any other.
class CornerElimination final : public Elimination {
public:
  /// The corner of `D` must be the candidates' nodes, each once, in their order. The arguments must outlive
  /// this object.
  CornerElimination(const Constraints& constraints, const SparseCholesky& D);

  void predict(Vec r, std::span<double> normal) const override;
  void finish(std::span<const double> lambda, Vec y) const override;
  [[nodiscard]] std::vector<double> condensed() const override;
  [[nodiscard]] double bytes() const override;

private:
  const Constraints& constraints_;
  const SparseCholesky& D_;
  std::vector<double> L_;                  ///< corner of the factor (c × c)
  mutable std::vector<double> z_, corner_; ///< corner of the last forward half; of a half under way (c)
};

/// By any solver, with the columns D⁻¹N stored where they fit the memory allowed; a step with contact takes a
/// second solve where they do not.
class ColumnElimination final : public Elimination {
public:
  /// One solve per candidate. Collective. The references must outlive this object. Throws Interrupted,
  /// SolverFailure.
  ColumnElimination(const Constraints& constraints, const LinearSolver& D, Vec layout, double memory);

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
