// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/simplex_qp.h"
#include "linalg/dense.h"
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

namespace signorini {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// One run of the method, with weights w and the set A of vectors with positive weight. The vectors of A are
/// affinely independent; therefore K_AA is positive definite for K = G + s 11ᵀ.
class Search {
public:
  /// Starts with the weight 1 on the vector whose value alone is least.
  Search(std::span<const double> G, std::span<const double> e)
      : G_(G), e_(e), n_(e.size()), w_(n_), factor_(n_) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < n_; ++i)
      if (entry(i, i) / 2 + e[i] < entry(best, best) / 2 + e[best])
        best = i;
    w_[best] = 1;
    enter(best);
  }

  [[nodiscard]] const std::vector<double>& weights() const { return w_; }

  /// Moves w to the minimum over the affine combinations of A. If a weight falls to zero on the way, its
  /// vector leaves A and the minimum is taken over the other vectors.
  void settle() {
    constexpr int passes = 2; // the second one removes the rounding of the first
    for (int whole = 0; whole < passes;) {
      std::vector<double> d = slopes_on_set();
      minimise(d, 1 - std::reduce(w_.begin(), w_.end())); // loss of Σ w = 1 by rounding
      whole += move(d, 1);
    }
  }

  struct Candidate {
    std::size_t index; ///< vector with the steepest descent; n if no vector descends by more than rounding
    double excess;     ///< upper bound of the present value's distance from the minimum, by convexity
  };
  [[nodiscard]] Candidate candidate() const {
    constexpr double rounding = 1e-14; // n ε, the sums' rounding
    std::vector<double> slopes(e_.begin(), e_.end()), sizes(n_);
    double mean = 0, size = 0;
    for (std::size_t i = 0; i < n_; ++i) {
      sizes[i] = std::abs(e_[i]);
      for (std::size_t j : A_) {
        slopes[i] += entry(i, j) * w_[j];
        sizes[i] += std::abs(entry(i, j)) * w_[j];
      }
      mean += w_[i] * slopes[i];
      size += w_[i] * sizes[i];
    }
    Candidate found{n_, mean - std::ranges::min(slopes)};
    for (std::size_t i = 0; i < n_; ++i)
      if (w_[i] == 0 && slopes[i] - mean < -rounding * (sizes[i] + size) &&
          (found.index == n_ || slopes[i] < slopes[found.index]))
        found.index = i;
    return found;
  }

  /// Adds j to A. If j depends affinely on A, the weights move along this dependence, on which the value is
  /// linear, until one weight falls to zero; the vector of this weight, possibly j, leaves A.
  void enter(std::size_t j) {
    constexpr double dependent = 1e-15; // the pivot is then rounding
    for (;;) {
      fit_shift(j);
      std::vector<double> d;
      for (std::size_t i : A_)
        d.push_back(entry(i, j) + shift_);
      A_.push_back(j);
      if (factor_.append(d, entry(j, j) + shift_, dependent))
        return;
      minimise(d, -1);
      d.push_back(1);
      const std::vector<double> slopes = slopes_on_set();
      if (std::inner_product(d.begin(), d.end(), slopes.begin(), 0.0) > 0)
        std::ranges::transform(d, d.begin(), std::negate());
      move(d, infinity);
      if (A_.back() != j)
        return;
      A_.pop_back();
    }
  }

private:
  [[nodiscard]] double entry(std::size_t i, std::size_t j) const { return G_[i * n_ + j]; }

  /// Components of Gw + e on A minus their mean. The mean changes no direction, but would cost digits.
  [[nodiscard]] std::vector<double> slopes_on_set() const {
    std::vector<double> slopes;
    double mean = 0;
    for (std::size_t i : A_) {
      slopes.push_back(std::inner_product(w_.begin(), w_.end(), &G_[i * n_], e_[i] - e_[A_.front()]));
      mean += w_[i] * slopes.back();
    }
    for (double& slope : slopes)
      slope -= mean;
    return slopes;
  }

  /// Replaces c by the vector d that minimises ½ d·G_AA d + c·d subject to Σ d = `sum`: the sum of −K⁻¹c and
  /// a multiple of K⁻¹1.
  void minimise(std::vector<double>& c, double sum) const {
    std::vector<double> ones(c.size(), 1.0);
    factor_.solve(c);
    factor_.solve(ones);
    for (double& x : c)
      x = -x;
    for (int pass = 0; pass < 2; ++pass) { // the second one removes the rounding of the first
      const double part = (sum - std::reduce(c.begin(), c.end())) / std::reduce(ones.begin(), ones.end());
      for (std::size_t k = 0; k < c.size(); ++k)
        c[k] += part * ones[k];
    }
  }

  /// Sets w_A += t d with the largest t ≤ `most` that keeps w ≥ 0. Vectors whose weight becomes zero leave A.
  /// Returns whether A is unchanged.
  bool move(const std::vector<double>& d, double most) {
    std::size_t first = A_.size();
    for (std::size_t k = 0; k < A_.size(); ++k)
      if (w_[A_[k]] < -most * d[k]) {
        most = w_[A_[k]] / -d[k];
        first = k;
      }
    for (std::size_t k = 0; k < A_.size(); ++k)
      w_[A_[k]] = k == first ? 0 : std::max(0.0, w_[A_[k]] + most * d[k]);
    const std::size_t before = A_.size();
    for (std::size_t k = before; k-- > 0;)
      if (w_[A_[k]] == 0) {
        A_.erase(A_.begin() + static_cast<std::ptrdiff_t>(k));
        if (k < factor_.size())
          factor_.remove(k);
      }
    return A_.size() == before;
  }

  /// Adapts the shift s to the size of the products that have large weights; otherwise a long vector with a
  /// small weight would cost the others digits.
  void fit_shift(std::size_t j) {
    double size = 0;
    for (std::size_t i = 0; i < n_; ++i)
      size += w_[i] * entry(i, i);
    if (!(size > 0))
      size = entry(j, j) > 0 ? entry(j, j) : 1;
    constexpr double near = 10;
    if (shift_ < near * size && size < near * shift_)
      return;
    shift_ = size;
    factor_.clear();
    for (std::size_t i : std::exchange(A_, {}))
      enter(i);
  }

  std::span<const double> G_, e_;
  std::size_t n_;
  std::vector<double> w_;
  std::vector<std::size_t> A_; ///< indices of the vectors, in the order of the factor
  double shift_ = 0;           ///< shift s of K
  UpdatedCholesky factor_;     ///< factor of K_AA
};

} // namespace

std::optional<std::vector<double>> simplex_qp(std::span<const double> G, std::span<const double> e) {
  const std::size_t n = e.size();
  const auto finite = [](double x) { return std::isfinite(x); };
  if (n == 0 || !std::ranges::all_of(G, finite) || !std::ranges::all_of(e, finite))
    return std::nullopt;
  // Every change lowers the value, so that no A returns; if rounding prevents that, the best weights count.
  const std::size_t most = 20 * n;
  Search search(G, e);
  std::optional<std::vector<double>> best;
  double least = infinity;
  for (std::size_t change = 0; change < most; ++change) {
    search.settle();
    const auto [index, excess] = search.candidate();
    if (excess < least) {
      least = excess;
      best = search.weights();
    }
    if (index == n)
      break;
    search.enter(index);
  }
  return best;
}

} // namespace signorini
