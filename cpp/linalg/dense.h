// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <span>
#include <vector>

namespace signorini {

/// Factorises a symmetric positive definite K (n × n) in place by LAPACK's Cholesky (lower triangle). Returns
/// 0, or the number, from 1, of the first pivot that is not positive.
int factorise_dense(std::span<double> K, std::size_t n);

/// Solves K x = b in place with that factor, for each column of b (n × columns, column by column).
void solve_factorised(std::span<const double> factor, std::size_t n, std::span<double> b);

/// Replaces that factor by K⁻¹, both triangles. Returns 0, or the number, from 1, of a pivot that is zero.
int invert_factorised(std::span<double> factor, std::size_t n);

/// Eigenvalues of a symmetric K (n × n), ascending, by LAPACK; K becomes the eigenvectors, one after another.
/// Throws SolverFailure.
std::vector<double> symmetric_eigenvalues(std::span<double> K, std::size_t n);

/// Solves K x = b in place for a symmetric positive definite K (n × n), for each column of b (n × columns,
/// column by column). Returns false, with b as it was, if K is not positive definite.
[[nodiscard]] bool solve_dense(std::vector<double> K, std::span<double> b);

/// Solves K x = b, or Kᵀ x = b, in place for a general K (n × n, column by column), which becomes its factors
/// LU. Returns 0, or the number, from 1, of the first pivot that is zero.
[[nodiscard]] int solve_general(std::span<double> K, std::size_t n, bool transposed, std::span<double> b);

/// BLAS on arrays of this rank, also beyond its 32-bit counts; x and y of equal length. Not collective.

/// y += a x.
void axpy(double a, std::span<const double> x, std::span<double> y);

/// x *= a.
void scale(double a, std::span<double> x);

/// x·y.
double dot(std::span<const double> x, std::span<const double> y);

/// y += Σ a_i x_i, for arrays x_i of the length of y.
void add(std::span<const double> a, std::span<const float* const> x, std::span<double> y);

/// x_i·y (arrays), for arrays x_i of the length of y.
void dots(std::span<const float* const> x, std::span<const double> y, std::span<double> products);

/// C = A B, for A (m × n), B (n × k) and C, column by column; m·n within 32 bits. Not within a parallel
/// region: OpenBLAS built for one thread, such as Debian's libopenblas0-serial, confuses concurrent products.
void multiply(std::span<const double> A, std::span<const double> B, std::span<double> C, std::size_t n);

/// Cholesky factorisation K_AA = RᵀR for a symmetric K and a list A of k of its indices. An index can be
/// appended to A or removed from it, each in O(k²) (Golub, Van Loan, Matrix Computations, section 6.5). K is
/// passed column by column; vectors are in the order of A. Not collective.
class UpdatedCholesky {
public:
  /// Reserves room for `most` indices; up to that number nothing more is allocated.
  explicit UpdatedCholesky(std::size_t most = 0) {
    R_.reserve(most * (most + 1) / 2);
    rotations_.reserve(most);
  }

  [[nodiscard]] std::size_t size() const { return size_; }

  /// Empties A.
  void clear();

  /// Appends an index j, whose `column` is K_Aj (k) and whose `diagonal` is K_jj. Returns false, and changes
  /// nothing, if the pivot (the rest of K_jj after elimination of A) is not above `negligible` K_jj: j then
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

  /// Start of column j of R, which has rows 0 … j.
  [[nodiscard]] static std::size_t start(std::size_t j) { return j * (j + 1) / 2; }
  /// x ← R⁻ᵀ x (k).
  void forward(std::span<double> x) const;

  std::size_t size_ = 0;
  std::vector<double> R_;
  std::vector<Rotation> rotations_;
};

} // namespace signorini
