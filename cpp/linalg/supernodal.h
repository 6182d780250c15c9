// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/lane_kernels.h"
#include <cholmod.h>
#include <cstddef>
#include <span>
#include <vector>

namespace signorini {

/// Forward and backward solves with a supernodal factor L of CHOLMOD (real, 32-bit indices), on the threads
/// of OpenMP. Independent subtrees of the elimination tree are solved in parallel, each by one thread. The
/// supernodes above the subtrees are solved one after another, each by all threads, which share its rows or
/// columns. This division and the order of every sum depend on L alone, so that results are bitwise equal for
/// any number of threads.
///
/// The solves are faster than CHOLMOD's also on one thread, since they prefetch the next supernodes from
/// memory, while CHOLMOD calls the BLAS for every supernode (`./dev bench scaling`).
class TriangularSolves {
public:
  /// Plans the division of the solves. `L` must outlive this object unchanged.
  explicit TriangularSolves(const cholmod_factor& L);

  /// Replaces z (n) by L⁻¹ z. Only one call of forward() or backward() at a time. Not collective.
  void forward(std::span<double> z);
  /// Replaces z (n) by L⁻ᵀ z. Only one call of forward() or backward() at a time. Not collective.
  void backward(std::span<double> z);

  /// Replaces each right-hand side z by L⁻¹ z, reading the factor once for all. The order of sums differs
  /// from that for a single z, but depends neither on the number of right-hand sides nor on the place of one
  /// among them. Only one call at a time. Not collective.
  void forward(std::span<const LaneGroup> groups);
  /// Replaces each right-hand side z by L⁻ᵀ z, as above.
  void backward(std::span<const LaneGroup> groups);

  /// Memory that this object takes in addition to the factor, bytes.
  [[nodiscard]] std::size_t bytes() const;

private:
  /// Subtree of the elimination tree: a range of supernodes that ends with the root. Its columns also have
  /// entries in rows outside the subtree; all these rows are among those of the root below its diagonal
  /// block.
  struct Subtree {
    int first, root;
    std::size_t outside; ///< start of this subtree's entries in outside_
  };
  /// Range of supernodes above the subtrees: either one supernode divided among all threads, or several small
  /// ones that one thread solves.
  struct Trunk {
    int first, last;
    bool divided;
  };

  /// Part of outside_lanes_ for one subtree and group.
  [[nodiscard]] double* outside_of(const Subtree& subtree, std::span<const LaneGroup> groups,
                                   std::size_t group);
  void forward(const Subtree& subtree, std::span<const LaneGroup> groups);
  void backward(const Subtree& subtree, std::span<const LaneGroup> groups);
  void forward_trunk(const Trunk& trunk, std::span<const LaneGroup> groups);
  void backward_trunk(const Trunk& trunk, std::span<const LaneGroup> groups);

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
  /// Number of rows of each supernode that are below its diagonal block and inside its subtree.
  std::vector<int> inside_;
  /// For each entry of L.s that is a row outside the subtree of its supernode: position of the row among the
  /// root's rows below the diagonal block.
  std::vector<int> place_;
  /// Values in the rows outside each subtree: its contributions to them (forward), or z (backward).
  std::vector<double> outside_;
  std::vector<double> outside_lanes_;     ///< as outside_, for groups of right-hand sides
  std::vector<double> shared_;            ///< scratch for a divided supernode (L.maxesize entries)
  std::vector<std::vector<double>> work_; ///< scratch for each thread (L.maxesize entries)
};

} // namespace signorini
