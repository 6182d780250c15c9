// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <array>
#include <cmath>
#include <cstddef>

namespace signorini::contact {

/// Orthonormal basis q of the force directions n of constraints at one node, by Gram–Schmidt: n_j = Σ_k R_jk
/// q_k.
class NodeBasis {
public:
  /// Directions count as linearly dependent if orthogonalisation leaves less than this part of one of them:
  /// forces that distinguish them would be accurate to four digits only.
  static constexpr double parallel = 1e-6;

  explicit NodeBasis(int dim) : dim_(static_cast<std::size_t>(dim)) {}

  [[nodiscard]] std::size_t size() const { return size_; }

  void clear() { size_ = 0; }

  /// Adds a direction (dim). Returns false and adds nothing if it depends linearly on those already in the
  /// basis.
  bool add(const double* n) {
    std::array<double, 3> left{};
    std::copy(n, n + dim_, left.begin());
    std::array<double, 3> row{};
    for (int pass = 0; pass < 2; ++pass) // the second pass removes the rounding of the first
      for (std::size_t k = 0; k < size_; ++k) {
        const double part = along(k, left.data());
        row[k] += part;
        for (std::size_t c = 0; c < dim_; ++c)
          left[c] -= part * q_[k][c];
      }
    const double rest = std::hypot(left[0], left[1], left[2]);
    if (size_ == dim_ || !(rest > parallel * std::hypot(n[0], n[1], dim_ == 3 ? n[2] : 0)))
      return false;
    for (std::size_t c = 0; c < dim_; ++c)
      q_[size_][c] = left[c] / rest;
    row[size_] = rest;
    R_[size_++] = row;
    return true;
  }

  /// q_k·x.
  [[nodiscard]] double along(std::size_t k, const double* x) const {
    double sum = 0;
    for (std::size_t c = 0; c < dim_; ++c)
      sum += q_[k][c] * x[c];
    return sum;
  }

  /// x += Σ_k b_k q_k.
  void add_to(double* x, const std::array<double, 3>& b) const {
    for (std::size_t k = 0; k < size_; ++k)
      for (std::size_t c = 0; c < dim_; ++c)
        x[c] += b[k] * q_[k][c];
  }

  /// Coordinates of the shortest vector x with n_j·x = b_j: b ← R⁻¹ b.
  void shortest(std::array<double, 3>& b) const {
    for (std::size_t j = 0; j < size_; ++j) {
      for (std::size_t k = 0; k < j; ++k)
        b[j] -= R_[j][k] * b[k];
      b[j] /= R_[j][j];
    }
  }

  /// Coefficients a of the directions in the vector with coordinates b, Σ_j a_j n_j = Σ_k b_k q_k: b ← R⁻ᵀ b.
  void combine(std::array<double, 3>& b) const {
    for (std::size_t k = size_; k-- > 0;) {
      for (std::size_t j = k + 1; j < size_; ++j)
        b[k] -= R_[j][k] * b[j];
      b[k] /= R_[k][k];
    }
  }

private:
  std::size_t dim_, size_ = 0;
  std::array<std::array<double, 3>, 3> q_{}, R_{};
};

} // namespace signorini::contact
