// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/curvature.h"
#include "linalg/dense.h"

namespace signorini::optimize {

void Curvature::learn(const Coordinates& d, const Coordinates& y) {
  const double curvature = dot(d, y) / dot(d, d);
  least_ = known_.empty() ? curvature : std::min(least_, curvature);
  largest_ = std::max(largest_, norm(y) / norm(d));
  known_.emplace_back(d, y);
}

std::optional<std::vector<double>> Curvature::matrix(std::size_t n) const {
  std::vector<double> B(n * n);
  for (std::size_t i = 0; i < n; ++i)
    B[i * n + i] = least_;
  const std::size_t k = known_.size();
  std::vector<double> DD(k * k), DY(k * k), D(n * k), Y(n * k);
  for (std::size_t i = 0; i < k; ++i) {
    const auto& [d, y] = known_[i];
    for (std::size_t j = 0; j < k; ++j) {
      DD[i * k + j] = dot(d, known_[j].first);
      DY[i * k + j] = (dot(d, known_[j].second) + dot(known_[j].first, y)) / 2;
    }
    for (std::size_t c = 0; c < d.size(); ++c)
      D[c * k + i] = d[c];
    for (std::size_t c = 0; c < y.size(); ++c)
      Y[c * k + i] = y[c];
  }
  std::vector<double> by_DD = D, by_DY = Y;
  if (!solve_dense(DD, by_DD) || !solve_dense(DY, by_DY))
    return std::nullopt;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t l = 0; l < k; ++l)
        B[i * n + j] += Y[i * k + l] * by_DY[j * k + l] - least_ * D[i * k + l] * by_DD[j * k + l];
  return B;
}

} // namespace signorini::optimize
