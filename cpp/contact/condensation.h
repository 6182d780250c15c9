#pragma once
#include "contact/contact_state.h"
#include "contact/elimination.h"

namespace signorini::contact {

/// Solver of a step's linearisation: p with D p − μ = r, p·ν = 0 on an active set and μ a normal force on it.
/// It is its own transpose.
class SlidingSolver {
public:
  virtual ~SlidingSolver() = default;

  /// `p` holds a guess on entry, which direct solvers ignore; `r` and `p` must differ. Collective. Throws
  /// SolverFailure.
  virtual void solve_sliding(Vec r, const ActiveSet& set, Vec p) const = 0;
};

/// The step operator condensed to the contact candidates: S = NᵀD⁻¹N, docs/method.md section 5.
class Condensation final : public SlidingSolver {
public:
  /// Collective. The arguments must outlive this object.
  Condensation(const Constraints& constraints, const Elimination& elimination);

  /// S (m × m), symmetric, the same on every rank; singular where candidates depend on each other.
  [[nodiscard]] const std::vector<double>& S() const { return S_; }

  /// S⁻¹ (m × m). Throws SolverFailure if S is singular.
  [[nodiscard]] std::vector<double> inverse() const;

  /// b ← S_AA⁻¹ b on an independent set of candidates, entry by entry of the set, the same on every rank.
  /// Collective. Throws SolverFailure if S_AA is singular.
  void solve_active(const ActiveSet& set, std::span<double> b) const;

  /// Predicted gaps g⁰ = g(D⁻¹r) (m) for the ψ in force (m). Collective.
  void predict_gap(Vec r, std::span<const double> psi, std::span<double> gap) const;

  /// y with D y = r − Nλ and g(y) = 0 on an independent `set`, λ zero elsewhere, for the last r that gaps
  /// were predicted for and the ψ in force (m); `lambda` (m) holds the forces that the prediction calls for,
  /// and then λ, refined until the gaps vanish to rounding; `gap` (m) becomes g(y). Collective.
  void finish_closed(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
                     std::span<double> gap, Vec y) const;

  /// Of candidates that depend on each other the first ones carry all the force.
  void solve_sliding(Vec r, const ActiveSet& set, Vec p) const override;

  /// Memory on all ranks, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  /// solve_active() on this rank.
  void solve_here(const ActiveSet& set, std::span<double> b) const;
  void finish(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
              std::span<double> normal, Vec y) const;

  const Constraints& constraints_;
  const Elimination& elimination_;
  std::vector<double> S_;
  const std::vector<double> zero_; ///< (m)

  /// Work of const members; the factor of S_AA is kept while the set does not change.
  struct Work {
    ActiveSet factorised, independent;
    std::vector<double> factor, b, normal, mu;
  };
  mutable Work work_;
};

} // namespace signorini::contact
