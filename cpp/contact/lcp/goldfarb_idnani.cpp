// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/lcp/goldfarb_idnani.h"
#include "base/error.h"
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>

namespace signorini::contact {

namespace {

/// One run of the method: the problem and the iterate. The members of the set are in the order of the factor
/// of S_AA.
class Search {
public:
  Search(const Columns& S, std::span<const double> gap0, ActiveSet& set, std::span<double> lambda,
         GoldfarbIdnaniWork& work)
      : S_(S), gap0_(gap0), set_(set), lambda_(lambda), factor_(work.factor), r_(work.r) {
    set_.clear();
    factor_.clear();
    std::ranges::fill(lambda_, 0);
  }

  /// Number of the open candidate with the least gap below −tolerance; m if there is none.
  [[nodiscard]] std::size_t deepest(double tolerance) const {
    std::size_t j = gap0_.size();
    double least = -tolerance;
    for (std::size_t i = 0; i < gap0_.size(); ++i)
      if (const double g = gap(i); g < least && std::ranges::find(set_, static_cast<int>(i)) == set_.end())
        least = g, j = i;
    return j;
  }

  /// Raises λ_j until gap j closes or the force of a candidate of the set becomes zero; this candidate then
  /// leaves the set. Returns whether gap j is closed, or nothing if no force can close it.
  std::optional<bool> raise(std::size_t j, bool dependent) {
    take_column(j);
    factor_.solve(r_);
    double slope = entry(j, j), largest = 0;
    for (std::size_t i = 0; i < set_.size(); ++i) {
      slope -= r_[i] * entry(set_[i], j);
      largest = std::max(largest, std::abs(r_[i]));
    }
    const double g = gap(j) + entry(j, j) * lambda_[j];
    double step = dependent ? std::numeric_limits<double>::infinity() : std::max(0.0, -g / slope);
    std::size_t leaves = set_.size();
    for (std::size_t i = 0; i < set_.size(); ++i)
      if (r_[i] > 1e-10 * largest) // the others are rounding
        if (const double limit = force(i) / r_[i]; limit < step)
          step = limit, leaves = i;
    if (std::isinf(step))
      return std::nullopt;
    for (std::size_t i = 0; i < set_.size(); ++i)
      force(i) = std::max(0.0, force(i) - step * r_[i]);
    lambda_[j] += step;
    if (leaves == set_.size())
      return true;
    force(leaves) = 0;
    set_.erase(set_.begin() + static_cast<std::ptrdiff_t>(leaves));
    factor_.remove(leaves);
    return false;
  }

  /// Adds j to the set, and recomputes λ from the factor, so that rounding errors do not accumulate.
  void add(std::size_t j) {
    take_column(j);
    if (!factor_.append(r_, entry(j, j)))
      throw SolverFailure(
          fmt::format("the condensed matrix of {} independent constraints is singular", set_.size() + 1));
    set_.push_back(static_cast<int>(j));
    r_.clear();
    for (int i : set_)
      r_.push_back(-gap0_[i]);
    factor_.solve(r_);
    for (std::size_t i = 0; i < set_.size(); ++i)
      force(i) = std::max(0.0, r_[i]);
  }

private:
  [[nodiscard]] double entry(auto row, auto column) const { return S_(static_cast<int>(column))[row]; }
  double& force(std::size_t i) { return lambda_[set_[i]]; }
  [[nodiscard]] double gap(std::size_t j) const {
    double g = gap0_[j];
    for (int i : set_)
      g += entry(j, i) * lambda_[i];
    return g;
  }
  /// Sets r to the column S_Aj.
  void take_column(std::size_t j) {
    r_.clear();
    for (int i : set_)
      r_.push_back(entry(i, j));
  }

  const Columns& S_;
  std::span<const double> gap0_;
  ActiveSet& set_;
  std::span<double> lambda_;
  UpdatedCholesky& factor_;
  std::vector<double>& r_;
};

} // namespace

bool goldfarb_idnani(const Columns& S, std::span<const double> gap0, double tolerance, const Depends& depends,
                     ActiveSet& set, std::span<double> lambda, int& steps, GoldfarbIdnaniWork& work) {
  // Each full step raises the dual objective, so that a few times m steps suffice.
  const int most = 100 * static_cast<int>(gap0.size()) + 100;
  Search search(S, gap0, set, lambda, work);
  for (std::size_t j = 0; (j = search.deepest(tolerance)) < gap0.size();) {
    for (bool closed = false; !closed;) {
      if (++steps > most)
        throw SolverFailure(
            fmt::format("the active set did not settle in {} iterations: {} of {} candidates closed", most,
                        set.size(), gap0.size()));
      const std::optional<bool> raised = search.raise(j, depends(set, static_cast<int>(j)));
      if (!raised)
        return false;
      closed = *raised;
    }
    search.add(j);
  }
  std::ranges::sort(set);
  return true;
}

} // namespace signorini::contact
