// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/gauss_newton.h"
#include "linalg/dense.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace signorini::optimize {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

double dot(std::span<const double> a, std::span<const double> b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Quadratic model g·d + ½ d·Hd of ½ |r|² about one iterate.
struct Model {
  std::vector<double> g, H;
  std::size_t n;

  explicit Model(const LeastSquares& at) : g(at.gradient()), H(at.normal_matrix()), n(g.size()) {}

  [[nodiscard]] double value(const std::vector<double>& d) const {
    double sum = dot(g, d);
    for (std::size_t i = 0; i < n; ++i)
      sum += d[i] * dot({&H[i * n], n}, d) / 2;
    return sum;
  }

  /// Returns a flag for each unknown: true if no bound blocks it (n).
  [[nodiscard]] std::vector<bool> free_at(const std::vector<double>& x, const Box& box) const {
    std::vector<bool> free(n);
    for (std::size_t i = 0; i < n; ++i)
      free[i] = !box.blocks(i, x[i], g[i]);
    return free;
  }

  /// Sets the entries of `d` marked in `free` to the model's minimiser for fixed values of the others.
  /// `damping` (n) is added to H's diagonal. Entries of unknowns that the data do not determine are set to
  /// zero.
  void minimise(const std::vector<bool>& free, const std::vector<double>& damping,
                std::vector<double>& d) const {
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < n; ++i)
      if (free[i] && H[i * n + i] > 0)
        which.push_back(i);
    std::vector<double> K(which.size() * which.size()), b(which.size());
    for (std::size_t a = 0; a < which.size(); ++a) {
      b[a] = -g[which[a]];
      for (std::size_t j = 0; j < n; ++j)
        if (!free[j])
          b[a] -= H[which[a] * n + j] * d[j];
      for (std::size_t c = 0; c < which.size(); ++c)
        K[a * which.size() + c] = H[which[a] * n + which[c]];
    }
    for (std::size_t i = 0; i < n; ++i)
      if (free[i])
        d[i] = 0;
    // If JᵀJ is numerically singular, increase the shift until the Cholesky factorisation succeeds.
    constexpr double least_slack = 1e-14, most_slack = 1e-2, growth = 100;
    bool solved = which.empty();
    for (double slack = least_slack; !solved && slack < most_slack; slack *= growth) {
      std::vector<double> enlarged = K;
      for (std::size_t a = 0; a < which.size(); ++a)
        enlarged[a * which.size() + a] += damping[which[a]] + slack * H[which[a] * n + which[a]];
      solved = solve_dense(enlarged, b);
    }
    for (std::size_t a = 0; a < which.size(); ++a)
      d[which[a]] = solved ? b[a] : std::numeric_limits<double>::quiet_NaN();
  }

  /// Returns the step within bounds and step limits. Unknowns that would exceed these are fixed at them,
  /// round by round.
  [[nodiscard]] std::vector<double> step(const std::vector<double>& x, const Box& box,
                                         const std::vector<double>& damping) const {
    std::vector<double> d(n, 0.0);
    std::vector<bool> free = free_at(x, box);
    for (std::size_t round = 0; round <= n; ++round) {
      minimise(free, damping, d);
      bool within = true;
      for (std::size_t i = 0; i < n; ++i) {
        const double wanted = x[i] + d[i], kept = box.nearest(i, x[i], wanted);
        if (free[i] && kept != wanted) {
          d[i] = kept - x[i];
          free[i] = within = false;
        }
      }
      if (within)
        break;
    }
    return d;
  }

  [[nodiscard]] double decrement(const std::vector<double>& x, const Box& box) const {
    std::vector<double> d(n, 0.0);
    minimise(free_at(x, box), std::vector<double>(n, 0.0), d);
    const double squared = -dot(g, d);            // NaN stays NaN
    return squared <= 0 ? 0 : std::sqrt(squared); // −0 would show its sign
  }
};

} // namespace

double LeastSquares::value() const { return dot(residuals, residuals) / 2; }

std::vector<double> LeastSquares::gradient() const {
  std::vector<double> g;
  for (std::size_t j = 0; j < columns(); ++j)
    g.push_back(dot({&jacobian[j * residuals.size()], residuals.size()}, residuals));
  return g;
}

std::vector<double> LeastSquares::normal_matrix() const {
  const std::size_t n = columns(), m = residuals.size();
  std::vector<double> H(n * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j)
      H[i * n + j] = H[j * n + i] = dot({&jacobian[i * m], m}, {&jacobian[j * m], m});
  return H;
}

GaussNewtonResult
gauss_newton(const std::function<std::optional<LeastSquares>(std::span<const double> x)>& evaluate,
             GaussNewtonIterate start, const Box& box, const GaussNewtonOptions& options,
             const std::function<bool(const GaussNewtonIterate&)>& report) {
  constexpr double first_damping = 1e-3, least_damping = 1e-12, most_damping = 1e12;
  // Changes of J below this part of it are rounding; the gradient is accurate to more digits.
  constexpr double rounding = 1e-12;
  GaussNewtonIterate now = std::move(start);
  if (now.damping == 0)
    now.damping = first_damping;
  double growth = 2;
  std::optional<double> stuck; // decrement before a step whose predicted decrease was rounding
  for (;; ++now.number) {
    const Model model(now.at);
    now.scales.resize(model.n);
    for (std::size_t i = 0; i < model.n; ++i)
      now.scales[i] = std::max(now.scales[i], model.H[i * model.n + i]);
    now.decrement = model.decrement(now.x, box);
    options.agree({&now.decrement, 1});
    if (!report(now))
      return {Stop::interrupted, std::move(now)};
    if (!std::isfinite(now.decrement))
      return {Stop::solver_failed, std::move(now)};
    if (stuck && now.decrement >= *stuck) // no better than before: rounding
      return {Stop::no_decrease, std::move(now)};
    stuck.reset();
    if (now.decrement <= options.tolerance)
      return {Stop::gradient_tolerance, std::move(now)};
    if (now.number >= options.max_iterations)
      return {Stop::iteration_limit, std::move(now)};
    bool failed = false;
    for (;;) {
      // Where a sensitivity almost vanishes, its present square would damp this unknown too little.
      std::vector<double> damping = now.scales;
      for (double& one : damping)
        one *= now.damping;
      std::vector<double> d = model.step(now.x, box, damping);
      options.agree(d);
      std::vector<double> x = now.x;
      for (std::size_t i = 0; i < x.size(); ++i)
        x[i] = std::clamp(x[i] + d[i], box.lower[i], box.upper[i]);
      const double predicted = -model.value(d), value = now.at.value();
      std::optional<LeastSquares> found = evaluate(x);
      failed = !found;
      const double decrease = found ? value - found->value() : -infinity;
      const bool below_rounding = predicted <= rounding * value;
      if (found && std::isfinite(decrease) &&
          (below_rounding ? decrease >= -rounding * value : decrease > 1e-4 * predicted)) {
        const double gain = below_rounding ? 1 : decrease / predicted;
        now.damping =
            std::max(least_damping, now.damping * std::max(1.0 / 10, 1 - std::pow(2 * gain - 1, 3)));
        growth = 2;
        now.x = std::move(x);
        now.at = *std::move(found);
        if (below_rounding)
          stuck = now.decrement;
        break;
      }
      now.damping *= growth;
      growth *= 2;
      if (now.damping > most_damping)
        return {failed ? Stop::solver_failed : Stop::no_decrease, std::move(now)};
    }
  }
}

Identified identified(const std::vector<double>& H, std::size_t n) {
  Identified found{.deviations = std::vector<double>(n, infinity),
                   .correlations = std::vector<double>(n * n),
                   .singular_values = {},
                   .unidentified = {}};
  std::vector<double> length(n), C(n * n);
  for (std::size_t i = 0; i < n; ++i)
    length[i] = std::sqrt(H[i * n + i]);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      C[i * n + j] = i == j ? 1 : length[i] * length[j] > 0 ? H[i * n + j] / (length[i] * length[j]) : 0;
  for (std::size_t i = 0; i < n; ++i)
    if (!(length[i] > 0)) {
      C[i * n + i] = 0;
      found.unidentified.emplace_back(n, 0.0)[i] = 1;
    }
  std::vector<double> vectors = C;
  const std::vector<double> values = symmetric_eigenvalues(vectors, n); // ascending
  // C is right to about 1e-12, by the tolerance of the sweeps.
  constexpr double rounding = 1e-11;
  std::vector<double> covariance(n * n);
  std::vector<bool> lost(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double* vector = &vectors[k * n];
    found.singular_values.insert(found.singular_values.begin(), std::sqrt(std::max(values[k], 0.0)));
    if (values[k] > rounding) {
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
          covariance[i * n + j] += vector[i] * vector[j] / values[k];
      continue;
    }
    std::vector<double> direction(n);
    double largest = 0;
    for (std::size_t i = 0; i < n; ++i) {
      direction[i] = length[i] > 0 ? vector[i] / length[i] : 0;
      if (std::abs(direction[i]) > std::abs(largest))
        largest = direction[i];
    }
    constexpr double little = 1e-4;
    for (std::size_t i = 0; i < n; ++i) {
      direction[i] = largest != 0 ? direction[i] / largest : 0;
      if (std::abs(direction[i]) < little)
        direction[i] = 0;
      lost[i] = lost[i] || direction[i] != 0;
    }
    if (largest != 0)
      found.unidentified.push_back(direction);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (length[i] > 0 && !lost[i])
      found.deviations[i] = std::sqrt(covariance[i * n + i]) / length[i];
    for (std::size_t j = 0; j < n; ++j)
      found.correlations[i * n + j] =
          i == j ? 1
                 : covariance[i * n + j] / std::sqrt(std::max(covariance[i * n + i] * covariance[j * n + j],
                                                              std::numeric_limits<double>::min()));
  }
  return found;
}

} // namespace signorini::optimize
