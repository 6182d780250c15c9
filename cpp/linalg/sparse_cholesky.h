// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/linear_solver.h"
#include "linalg/lockstep.h"
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace signorini {

class KeptPlace;

/// Elimination order of the nodes of a matrix, with the nodes of the trailing block last. It can be reused
/// for any matrix with the same nonzero pattern.
struct EliminationOrder {
  std::vector<int> nodes;
  double entries = 0; ///< number of entries of the factor without the trailing block
};

/// Direct solver by CHOLMOD on one rank: the factorisation P A Pᵀ = L Lᵀ with separate forward and backward
/// solves (docs/method.md section 5). The nodes of the trailing block (the contact candidates) come last in
/// the elimination order. Therefore the last c ≪ n entries of the forward solution L⁻¹ P b contain the whole
/// effect of b on the trailing block. Changing these entries before the backward solve has the same effect on
/// the solution as a load on the trailing block.
class SparseCholesky final : public LinearSolver {
public:
  /// Analyses `matrix` (sequential BAIJ), which is copied, and counts the factor's entries. `trailing_block`:
  /// nodes (rows of blocks), in the order in which the entries of the trailing block are wanted; `most`:
  /// largest number of entries that can be indexed; `order`: elimination order of a matrix with the same
  /// nonzero pattern; if empty, an order is computed. Throws SolverFailure.
  SparseCholesky(Mat matrix, std::span<const int> trailing_block,
                 double most = std::numeric_limits<int>::max(), const EliminationOrder& order = {});
  ~SparseCholesky() override;

  [[nodiscard]] const EliminationOrder& order() const { return order_; }

  /// Whether the factor's entries can be indexed; if not, factorise() throws SolverFailure.
  [[nodiscard]] bool indexable() const { return indexable_; }

  /// Memory that the factorisation will take, from the count of the factor's entries, bytes. Only a lower
  /// bound if indexable() is false.
  [[nodiscard]] double estimate() const;

  /// Work of the factorisation; call this only if indexable() is true.
  [[nodiscard]] FactorWork work() const;

  /// Computes the factor. Call this once, before any solve. Throws SolverFailure.
  void factorise();

  void solve(Vec b, Vec x) const override;
  [[nodiscard]] std::string name() const override { return "CHOLMOD"; }
  [[nodiscard]] double bytes() const override;

  /// Number c of entries of the trailing block: its number of nodes times the block size.
  [[nodiscard]] int trailing_size() const { return trailing_size_; }
  /// Returns the trailing diagonal block of L (c × c, column by column, lower triangle). Call factorise()
  /// first.
  [[nodiscard]] std::vector<double> trailing_factor() const;

  /// Number n of unknowns.
  [[nodiscard]] std::size_t size() const;
  /// Forward solution z = L⁻¹ P b.
  class Forward {
  public:
    /// Returns the last entries of z (c), which belong to the trailing block.
    [[nodiscard]] std::span<const double> trailing_block() const { return trailing_; }

  private:
    friend class SparseCholesky;
    std::vector<double> z_, trailing_;
    std::shared_ptr<KeptPlace> place_; ///< of z if it was computed with those of other tasks
    bool among_others_ = false;        ///< whether it was; z_ is then undefined
  };
  /// Creates storage for a forward solution.
  [[nodiscard]] Forward storage() const;
  /// Forward solve z = L⁻¹ P b.
  void forward(Vec b, Forward& z) const;
  /// Backward solve x = Pᵀ L⁻ᵀ z, where the last c entries of z are replaced by `trailing_block` (c); by none
  /// if it is empty. z stays.
  void backward(const Forward& z, std::span<const double> trailing_block, Vec x) const;

  /// Makes the solves of the tasks of `lockstep` together; null: no more. A factor that is solved with in
  /// another format alone is then computed a second time.
  void unite(Lockstep* lockstep) const;

private:
  struct Cholmod;                    ///< CHOLMOD's objects
  [[nodiscard]] bool shared() const; ///< whether the caller is a task whose solves are made with others
  std::unique_ptr<Cholmod> c_;
  int trailing_size_;
  EliminationOrder order_;
  bool indexable_ = true;
  double entries_ = 0; ///< entries of the factor, not counting the zeros that pad supernodes
};

} // namespace signorini
