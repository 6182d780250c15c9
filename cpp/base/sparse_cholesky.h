#pragma once
#include "base/linear_solver.h"
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace signorini {

/// Factorisation by CHOLMOD on one rank, the two triangular halves of a solve apart: P A Pᵀ = L Lᵀ with
/// chosen nodes (the corner) last in the elimination order. After the forward half L⁻¹ P b the last entries
/// hold all that the corner feels of b, in c ≪ n numbers; changing them before the backward half changes the
/// solution as a load on the corner would.
class SparseCholesky final : public LinearSolver {
public:
  /// Orders and counts. `matrix` is a sequential BAIJ matrix, used until factorise() only; `corner` are nodes
  /// (blocks), in the order in which the corner's entries are wanted; `most` entries can be numbered. Throws
  /// SolverFailure.
  SparseCholesky(Mat matrix, std::span<const int> corner, double most = std::numeric_limits<int>::max());
  ~SparseCholesky() override;

  /// Whether the factor's entries can be numbered: there is none to be made where they cannot.
  [[nodiscard]] bool possible() const { return possible_; }

  /// Memory that the factorisation will take, as counted, bytes; where it is not possible, at least.
  [[nodiscard]] double estimate() const;

  /// To be called once before solves. Throws SolverFailure.
  void factorise();

  void solve(Vec b, Vec x) const override;
  [[nodiscard]] std::string name() const override { return "CHOLMOD"; }
  [[nodiscard]] double bytes() const override;

  /// Entries of the corner: its nodes times the block size.
  [[nodiscard]] int corner_size() const { return corner_size_; }
  /// Last diagonal block of L (c × c, column by column, lower).
  [[nodiscard]] std::vector<double> corner_factor() const;

  /// Forward half: z = L⁻¹ P b, kept until the next one; returns its corner (c).
  std::span<const double> forward(Vec b) const;
  /// Backward half: x = Pᵀ L⁻ᵀ z with `corner` in place of the corner of z.
  void backward(std::span<const double> corner, Vec x) const;

private:
  struct Cholmod; ///< CHOLMOD's objects
  std::unique_ptr<Cholmod> c_;
  int corner_size_;
  bool possible_ = true;
  double entries_ = 0; ///< of the factor without what supernodes add
};

} // namespace signorini
