#include "contact/lcp/goldfarb_idnani.h"
#include "base/dense.h"
#include "base/error.h"
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::contact {

namespace {

/// b ← S_AA⁻¹ b.
void solve_on_set(std::span<const double> S, std::size_t m, const ActiveSet& set, std::vector<double>& factor,
                  std::span<double> b) {
  factor.clear();
  for (int i : set)
    for (int j : set)
      factor.push_back(S[static_cast<std::size_t>(i) * m + static_cast<std::size_t>(j)]);
  if (const int pivot = factorise_dense(factor, set.size()); pivot != 0)
    throw SolverFailure(fmt::format(
        "the condensed matrix of {} independent constraints is singular (pivot {})", set.size(), pivot));
  solve_factorised(factor, set.size(), b.first(set.size()));
}

} // namespace

bool goldfarb_idnani(std::span<const double> S, std::span<const double> gap0, double tolerance,
                     const Depends& depends, ActiveSet& set, std::span<double> lambda, int& steps,
                     GoldfarbIdnaniWork& work) {
  auto& [factor, r] = work;
  const std::size_t m = gap0.size();
  const auto gap = [&](std::size_t j) {
    double g = gap0[j];
    for (int i : set)
      g += S[j * m + static_cast<std::size_t>(i)] * lambda[static_cast<std::size_t>(i)];
    return g;
  };
  // Each full step raises the dual objective, so that a few times m steps suffice.
  const int most = 100 * static_cast<int>(m) + 100;
  set.clear();
  std::ranges::fill(lambda, 0);
  for (;;) {
    std::size_t j = m;
    double deepest = -tolerance;
    for (std::size_t i = 0; i < m; ++i)
      if (const double g = gap(i); g < deepest && !std::ranges::binary_search(set, static_cast<int>(i)))
        deepest = g, j = i;
    if (j == m)
      break;
    // Raise λ_j until gap j is closed; on the way, candidates whose force falls to zero leave the set.
    for (bool closed = false; !closed;) {
      if (++steps > most)
        throw SolverFailure(fmt::format(
            "the active set did not settle in {} steps: {} of {} candidates closed", most, set.size(), m));
      r.clear();
      for (int i : set)
        r.push_back(S[static_cast<std::size_t>(i) * m + j]);
      solve_on_set(S, m, set, factor, r);
      double slope = S[j * m + j], largest = 0;
      for (std::size_t i = 0; i < set.size(); ++i) {
        slope -= r[i] * S[static_cast<std::size_t>(set[i]) * m + j];
        largest = std::max(largest, std::abs(r[i]));
      }
      const bool dependent = depends(set, static_cast<int>(j));
      const double g = gap(j) + S[j * m + j] * lambda[j];
      double step = dependent ? std::numeric_limits<double>::infinity() : std::max(0.0, -g / slope);
      std::size_t leaves = set.size();
      for (std::size_t i = 0; i < set.size(); ++i)
        if (r[i] > 1e-10 * largest) // the others are rounding
          if (const double limit = lambda[static_cast<std::size_t>(set[i])] / r[i]; limit < step)
            step = limit, leaves = i;
      if (std::isinf(step))
        return false;
      for (std::size_t i = 0; i < set.size(); ++i) {
        double& force = lambda[static_cast<std::size_t>(set[i])];
        force = std::max(0.0, force - step * r[i]);
      }
      lambda[j] += step;
      closed = leaves == set.size();
      if (!closed) {
        lambda[static_cast<std::size_t>(set[leaves])] = 0;
        set.erase(set.begin() + static_cast<std::ptrdiff_t>(leaves));
      }
    }
    set.insert(std::ranges::lower_bound(set, static_cast<int>(j)), static_cast<int>(j));
    // Recompute λ, so that rounding does not accumulate.
    r.clear();
    for (int i : set)
      r.push_back(-gap0[static_cast<std::size_t>(i)]);
    solve_on_set(S, m, set, factor, r);
    for (std::size_t i = 0; i < set.size(); ++i)
      lambda[static_cast<std::size_t>(set[i])] = std::max(0.0, r[i]);
  }
  return true;
}

} // namespace signorini::contact
