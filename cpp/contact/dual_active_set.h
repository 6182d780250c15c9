#pragma once
#include "contact/contact_state.h"
#include <functional>
#include <span>

namespace signorini::contact {

/// 0 ≤ λ ⟂ g⁰ + Sλ ≥ 0 for a symmetric S = NᵀKN, K positive definite, that is singular where the columns of N
/// depend on each other: the dual active-set method of Goldfarb and Idnani (1983), which ends after finitely
/// many steps with the solution or the proof that there is none. Its sets are independent at all times.
class DualActiveSet {
public:
  /// Whether column j of N depends on those of a set.
  using Depends = std::function<bool(const ActiveSet& set, int j)>;

  /// For up to m columns; solves within this size allocate nothing.
  explicit DualActiveSet(std::size_t m);

  /// Finds the set with λ > 0, ascending, and λ (m), for S (m × m) and g⁰ (m); negative gaps above
  /// −`tolerance` count as zero. False if there is no λ. Returns the number of steps in `steps`. Throws
  /// SolverFailure if rounding spoils the search.
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
