// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cholmod.h>
#include <cstddef>
#include <span>
#include <vector>

namespace signorini {

/// Forward and backward solves with a supernodal factor L of CHOLMOD (real, 32-bit indices), on the threads
/// of OpenMP. One thread each solves independent subtrees of the elimination tree; all threads solve the
/// supernodes above them one after another, each divided by rows or columns. The division and the order of
/// every sum depend on L alone, so results are the same to the last bit on any number of threads.
///
/// They are faster than CHOLMOD's own solves on one thread too, which call the BLAS for every supernode,
/// since they prefetch the next supernodes from memory (`./dev bench scaling`).
class TriangularSolves {
public:
  /// Plans the solves. `L` must outlive this object unchanged.
  explicit TriangularSolves(const cholmod_factor& L);

  /// z ← L⁻¹ z (n), in place. One solve at a time. Not collective.
  void forward(std::span<double> z);
  /// z ← L⁻ᵀ z (n), in place. One solve at a time. Not collective.
  void backward(std::span<double> z);

  /// Memory beside the factor.
  [[nodiscard]] std::size_t bytes() const;

private:
  /// A subtree: a range of supernodes, the last of them its root. The rows of L outside of it that its
  /// columns reach are those below the root's diagonal block.
  struct Subtree {
    int first, root;
    std::size_t outside; ///< start of its entries of outside_
  };
  /// Supernodes above the subtrees, one after another: a single one divided among all threads, or small ones
  /// for one thread.
  struct Trunk {
    int first, last;
    bool divided;
  };

  void plan_subtrees();
  void plan_trunk(const std::vector<bool>& in_trunk);
  void number_outside_rows();

  void forward(const Subtree& subtree, std::span<double> z, std::span<double> work);
  void backward(const Subtree& subtree, std::span<double> z, std::span<double> work);
  void forward_together(int s, std::span<double> z);
  void backward_together(int s, std::span<double> z);

  const cholmod_factor& L_;
  std::vector<Subtree> subtrees_;
  std::vector<Trunk> trunk_;
  std::vector<int> inside_;     ///< number of rows below each supernode that lie in its subtree
  std::vector<int> place_;      ///< position of each row of L.s outside its subtree among rows below the root
  std::vector<double> outside_; ///< contributions of subtrees to the rows outside, or values from there
  std::vector<double> shared_;  ///< scratch of a divided supernode (maxesize)
  std::vector<std::vector<double>> work_; ///< scratch of each thread (maxesize)
};

} // namespace signorini
