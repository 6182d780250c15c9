// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <span>
#include <vector>

namespace signorini {

/// The Cholesky factorisation K_AA = RᵀR for a symmetric K and a list A of k of its indices, to which an
/// index can be appended and from which one can be removed, each in O(k²) (Golub, Van Loan, Matrix
/// Computations, section 6.5). K is passed column by column; vectors are in the order of A. Not collective.
class UpdatedCholesky {
public:
  /// With room for `most` indices, up to which nothing is allocated.
  explicit UpdatedCholesky(std::size_t most = 0) {
    R_.reserve(most * (most + 1) / 2);
    rotations_.reserve(most);
  }

  [[nodiscard]] std::size_t size() const { return size_; }

  /// Empties A.
  void clear();

  /// Appends an index j, whose `column` is K_Aj (k) and whose `diagonal` is K_jj. Returns false, with all as
  /// it was, if the pivot, what remains of K_jj when A is eliminated, is not above `negligible` K_jj: j then
  /// depends on A.
  [[nodiscard]] bool append(std::span<const double> column, double diagonal, double negligible = 0);

  /// Removes the index at position i of A.
  void remove(std::size_t i);

  /// b ← K_AA⁻¹ b (k).
  void solve(std::span<double> b) const;

private:
  struct Rotation {
    double cosine, sine;
  };

  /// Where column j of R begins, which holds rows 0 … j.
  [[nodiscard]] static std::size_t start(std::size_t j) { return j * (j + 1) / 2; }
  /// x ← R⁻ᵀ x (k).
  void forward(std::span<double> x) const;

  std::size_t size_ = 0;
  std::vector<double> R_;
  std::vector<Rotation> rotations_;
};

} // namespace signorini
