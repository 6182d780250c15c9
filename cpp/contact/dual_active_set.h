#pragma once
#include "contact/contact_state.h"
#include <functional>
#include <span>

namespace signorini::contact {

/// Solves 0 ≤ λ ⟂ g⁰ + Sλ ≥ 0 by the dual active-set method of Goldfarb and Idnani (1983), for a symmetric S
/// = NᵀKN with K positive definite, which is singular where the columns of N are linearly dependent. The
/// method ends after finitely many steps with the solution or the proof that there is none. Its active sets
/// are independent throughout.
class DualActiveSet {
public:
  /// Whether column j of N depends linearly on those of a set.
  using Depends = std::function<bool(const ActiveSet& set, int j)>;

  /// Reserves memory for m columns; solves up to this size allocate nothing.
  explicit DualActiveSet(std::size_t m);

  /// Finds the active set, ascending, and λ (m), for S (m × m) and g⁰ (m); negative gaps above −`tolerance`
  /// count as zero. Returns false if there is no λ. Adds the number of steps to `steps`. Throws SolverFailure
  /// if rounding keeps the search from ending or S_AA is singular.
  [[nodiscard]] bool solve(std::span<const double> S, std::span<const double> gap0, double tolerance,
                           const Depends& depends, ActiveSet& set, std::span<double> lambda,
                           int& steps) const;

private:
  /// b ← S_AA⁻¹ b.
  void solve_on_set(std::span<const double> S, std::size_t m, const ActiveSet& set,
                    std::span<double> b) const;

  mutable std::vector<double> factor_, r_;
};

} // namespace signorini::contact
