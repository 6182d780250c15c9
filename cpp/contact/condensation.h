#pragma once
#include "base/linear_solver.h"
#include "contact/constraints.h"
#include "contact/contact_state.h"

namespace signorini::contact {

/// The step operator condensed to the contact candidates: S = NᵀD⁻¹N, method.md section 6.
class Condensation {
public:
  /// One solve with D per candidate. Collective. The arguments must outlive this object.
  Condensation(const Constraints& constraints, const Factorisation& D, Vec layout);

  /// S (m × m), symmetric, the same on every rank.
  [[nodiscard]] const std::vector<double>& S() const { return S_; }

  /// S⁻¹ (m × m). Throws SolverFailure if S is singular.
  [[nodiscard]] std::vector<double> inverse() const;

  /// S_AA⁻¹ b on a set of candidates. Throws SolverFailure if S_AA is singular.
  [[nodiscard]] std::vector<double> solve_active(const ActiveSet& set, std::vector<double> b) const;

  /// y with D y = r − Nλ and g(y) = 0 on `set`, λ zero elsewhere; `lambda` (m) holds a guess, such as that of the gaps
  /// predicted by D⁻¹r, and then λ. Refined until the gaps vanish to rounding. Collective.
  void solve_closed(Vec r, const ActiveSet& set, std::span<double> lambda, Vec y) const;

  /// p with D p − μ = r, p·ν = 0 on `set` and μ a normal force on `set`: a step's linearisation, and its own
  /// transpose. `r` and `p` must differ. Collective.
  void solve_sliding(Vec r, const ActiveSet& set, Vec p) const;

private:
  void refine(Vec r, const ActiveSet& set, std::span<const double> psi, std::span<double> lambda, Vec y) const;

  const Constraints& constraints_;
  const Factorisation& D_;
  std::vector<double> S_;
  petsc::Vector work_;
};

} // namespace signorini::contact
