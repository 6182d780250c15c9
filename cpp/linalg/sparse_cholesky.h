// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/linear_solver.h"
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace signorini {

/// Elimination order of the nodes, with those of the trailing block last, for all matrices with the same
/// nonzero pattern.
struct EliminationOrder {
  std::vector<int> nodes;
  double entries = 0; ///< entries of the factor without the trailing block
};

/// Factorisation P A Pᵀ = L Lᵀ by CHOLMOD on one rank, with separate forward and backward solves
/// (docs/method.md section 5). Chosen nodes (the trailing block, here the contact candidates) are last in the
/// elimination order. After the forward solve L⁻¹ P b the last c ≪ n entries contain the whole effect of b on
/// the trailing block. A change of them before the backward solve acts on the solution like a load on that
/// block.
class SparseCholesky final : public LinearSolver {
public:
  /// Chooses the elimination order, or takes `order`, if not empty, from a matrix with the same nonzero
  /// pattern; counts the factor's entries. `matrix`: sequential BAIJ, copied; `trailing_block`: nodes
  /// (blocks), in the order in which the trailing block's entries are wanted; `most`: number of entries that
  /// can be indexed. Throws SolverFailure.
  SparseCholesky(Mat matrix, std::span<const int> trailing_block,
                 double most = std::numeric_limits<int>::max(), const EliminationOrder& order = {});
  ~SparseCholesky() override;

  [[nodiscard]] const EliminationOrder& order() const { return order_; }

  /// Whether the factor's entries can be indexed; if not, factorise() throws.
  [[nodiscard]] bool possible() const { return possible_; }

  /// Memory of the factorisation by the count of its entries, bytes; a lower bound if it is not possible().
  [[nodiscard]] double estimate() const;

  /// Work of a factorisation that is possible().
  [[nodiscard]] FactorWork work() const;

  /// Computes the factor; to be called once before solves. Throws SolverFailure.
  void factorise();

  void solve(Vec b, Vec x) const override;
  [[nodiscard]] std::string name() const override { return "CHOLMOD"; }
  [[nodiscard]] double bytes() const override;

  /// Entries of the trailing block: its nodes times the block size.
  [[nodiscard]] int trailing_size() const { return trailing_size_; }
  /// Last diagonal block of L (c × c, column by column, lower triangle), after factorise().
  [[nodiscard]] std::vector<double> corner_factor() const;

  /// Unknowns n.
  [[nodiscard]] std::size_t size() const;
  /// Forward solve z = L⁻¹ P b (n), whose last trailing_size() entries are the trailing block's.
  void forward(Vec b, std::span<double> z) const;
  /// Backward solve x = Pᵀ L⁻ᵀ z for a z (n) whose last entries are replaced by `trailing_block` (c).
  void backward(std::span<const double> z, std::span<const double> trailing_block, Vec x) const;

private:
  struct Cholmod; ///< CHOLMOD's objects
  std::unique_ptr<Cholmod> c_;
  int trailing_size_;
  EliminationOrder order_;
  bool possible_ = true;
  double entries_ = 0; ///< entries of the factor, without the zeros that pad supernodes
};

} // namespace signorini
