// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <span>
#include <vector>

namespace signorini {

/// Replaces a symmetric positive definite K (n × n) by its Cholesky factor in the lower triangle (LAPACK).
/// Returns 0, or the number, counted from 1, of the first pivot that is not positive.
int factorise_dense(std::span<double> K, std::size_t n);

/// Solves K x = b with the factor of K from factorise_dense(); `b` (n × columns, column by column) is
/// replaced by x.
void solve_factorised(std::span<const double> factor, std::size_t n, std::span<double> b);

/// Replaces the factor of K from factorise_dense() by K⁻¹ (both triangles). Returns 0, or the number, counted
/// from 1, of the first pivot that is zero.
int invert_factorised(std::span<double> factor, std::size_t n);

/// Computes the eigenvalues of a symmetric K (n × n), ascending, by LAPACK. K is replaced by the orthonormal
/// eigenvectors, one after another in the order of the eigenvalues. Throws SolverFailure.
std::vector<double> symmetric_eigenvalues(std::span<double> K, std::size_t n);

/// Solves K x = b for a symmetric positive definite K (n × n); `b` (n × columns, column by column) is
/// replaced by x. Returns false and leaves b unchanged if K is not positive definite.
[[nodiscard]] bool solve_dense(std::vector<double> K, std::span<double> b);

/// Solves K x = b or, if `transposed`, Kᵀ x = b for a general K (n × n, column by column); b is replaced by
/// x, K by its factors LU. Returns 0, or the number, counted from 1, of the first pivot that is zero. `sign`:
/// receives the sign of K's determinant, 1 or −1, unless it is null.
[[nodiscard]] int solve_general(std::span<double> K, std::size_t n, bool transposed, std::span<double> b,
                                int* sign = nullptr);

/// BLAS operations on arrays of this rank, which may be longer than the BLAS's 32-bit counts. Arrays x and y
/// have equal length. Not collective.

/// y += a x.
void axpy(double a, std::span<const double> x, std::span<double> y);

/// x *= a.
void scale(double a, std::span<double> x);

/// x·y.
double dot(std::span<const double> x, std::span<const double> y);

/// y += Σ a_i x_i, where each array x_i has the length of y; x_i is in single precision.
void add(std::span<const double> a, std::span<const float* const> x, std::span<double> y);

/// Computes the products x_i·y, where each array x_i has the length of y; x_i is in single precision.
void dots(std::span<const float* const> x, std::span<const double> y, std::span<double> products);

/// C = A B for A (m × n), B (n × k) and C (m × k), all stored column by column, with m·n and n·k in the range
/// of 32-bit integers. Do not call this within a parallel region: concurrent products go wrong if OpenBLAS is
/// built for one thread, as Debian's libopenblas0-serial is.
void multiply(std::span<const double> A, std::span<const double> B, std::span<double> C, std::size_t n);

/// Cholesky factorisation K_AA = RᵀR, for a symmetric matrix K and a list A of k of its indices. Appending or
/// removing one index costs O(k²) (Golub, Van Loan, Matrix Computations, section 6.5). Vectors have their
/// entries in the order of A. Not collective.
class UpdatedCholesky {
public:
  /// Reserves memory for `most` indices; lists up to this length cause no further allocation.
  explicit UpdatedCholesky(std::size_t most = 0) {
    R_.reserve(most * (most + 1) / 2);
    rotations_.reserve(most);
  }

  [[nodiscard]] std::size_t size() const { return size_; }

  /// Makes A empty.
  void clear();

  /// Appends an index j to A. `column`: K_Aj (k entries); `diagonal`: K_jj. Returns false and changes nothing
  /// if the pivot (the Schur complement of K_jj after elimination of A) is at most `negligible` times K_jj:
  /// column j then depends linearly on those of A.
  [[nodiscard]] bool append(std::span<const double> column, double diagonal, double negligible = 0);

  /// Removes the index at position i of A.
  void remove(std::size_t i);

  /// Replaces b (k) by K_AA⁻¹ b.
  void solve(std::span<double> b) const;

private:
  struct Rotation {
    double cosine, sine;
  };

  /// Position in R_ at which column j of R starts; the column has the rows 0 … j.
  [[nodiscard]] static std::size_t start(std::size_t j) { return j * (j + 1) / 2; }
  /// Replaces x (k) by R⁻ᵀ x.
  void forward(std::span<double> x) const;

  std::size_t size_ = 0;
  std::vector<double> R_;
  std::vector<Rotation> rotations_;
};

} // namespace signorini
