#pragma once
#include "contact/contact_state.h"
#include "contact/elimination.h"

namespace signorini::contact {

/// Solver of a linearised or adjoint step on an active set (docs/method.md section 4): finds p with D p − μ =
/// r, p·ν = 0 on the set and normal forces μ there. The solution operator r ↦ p is symmetric.
class ActiveSetKkt {
public:
  virtual ~ActiveSetKkt() = default;

  /// Solves for `p`, which holds a guess on entry that direct solvers ignore; `r` and `p` must be different
  /// vectors. Collective. Throws SolverFailure.
  virtual void solve_sliding(Vec r, const ActiveSet& set, Vec p) const = 0;
};

/// The Delassus operator S = NᵀD⁻¹N: the step operator D condensed to the contact candidates (docs/method.md
/// section 5).
class DelassusOperator final : public ActiveSetKkt {
public:
  /// Collective. The arguments must outlive this object.
  DelassusOperator(const Constraints& constraints, const Elimination& elimination);

  /// S (m × m), symmetric, the same on every rank; singular where candidates are linearly dependent.
  [[nodiscard]] const std::vector<double>& S() const { return S_; }

  /// S⁻¹ (m × m). Throws SolverFailure if S is singular.
  [[nodiscard]] std::vector<double> inverse() const;

  /// b ← S_AA⁻¹ b for an independent `set` A; b has one entry per candidate of the set, and is the same on
  /// every rank on return. Collective. Throws SolverFailure if S_AA is singular.
  void solve_active(const ActiveSet& set, std::span<double> b) const;

  /// Predicted gaps g⁰ = g(D⁻¹r) (m), in metres, for the given ψ (m). Collective.
  void predict_gap(Vec r, std::span<const double> psi, std::span<double> gap) const;

  /// Solves D y = r − Nλ with g(y) = 0 on an independent `set` and λ = 0 elsewhere, for the r of the last
  /// predict_gap() and the given ψ (m). `lambda` (m) holds the λ found from the predicted gaps on entry, and
  /// on return λ refined until the gaps on the set vanish to rounding; `gap` (m) becomes g(y). Collective.
  /// Throws SolverFailure.
  void finish_closed(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
                     std::span<double> gap, Vec y) const;

  /// Of linearly dependent candidates the first ones carry the force.
  void solve_sliding(Vec r, const ActiveSet& set, Vec p) const override;

  /// Memory on all ranks, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  /// solve_active() on this rank alone.
  void solve_here(const ActiveSet& set, std::span<double> b) const;
  /// finish_closed(), returning ν_i·y (m) in `normal` instead of gaps.
  void finish(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
              std::span<double> normal, Vec y) const;

  const Constraints& constraints_;
  const Elimination& elimination_;
  std::vector<double> S_;
  const std::vector<double> zero_; ///< (m)

  /// Scratch of const members; the factor of S_AA is kept while the set does not change.
  struct Work {
    ActiveSet factorised, independent;
    std::vector<double> factor, b, normal, mu;
  };
  mutable Work work_;
};

} // namespace signorini::contact
