// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "linalg/lane_kernels.h"
#include "linalg/lockstep.h"
#include "linalg/side_by_side.h"
#include <memory>
#include <vector>

namespace signorini {

/// The product R x + M w with two symmetric matrices on one rank, which tasks of a Lockstep make together.
/// Sums do not depend on the number of tasks and threads.
class LaneProduct {
public:
  /// The matrices must outlive this object.
  LaneProduct(std::shared_ptr<const petsc::Matrix> R, Mat M) : R_(std::move(R)), M_(M) {}

  /// Makes the products of the tasks of `lockstep` together; null: no more. The first call copies both
  /// matrices, if they are of a kind (SBAIJ, MAIJ) for which that is possible.
  void unite(Lockstep* lockstep);

  /// r ← R x + M w; no two of them are the same vector. Tasks of the lockstep wait for each other if R is the
  /// matrix of this object; with other matrices R each makes its own product. Collective.
  void multiply(Mat R, Vec x, Vec w, Vec r);

  /// Memory of the copies, bytes.
  [[nodiscard]] std::size_t bytes() const;

private:
  class Asked;
  /// Both halves of a symmetric matrix in compressed rows of blocks.
  struct Copy {
    std::vector<int> begin, column;
    std::vector<double> values; ///< blocks by rows, or a number for each block that is its multiple of one
    int numbers = 0;            ///< of a block
    [[nodiscard]] BlockRows rows() const { return {begin.data(), column.data(), values.data(), numbers}; }
  };
  [[nodiscard]] static Copy copy(Mat matrix);
  void make(std::span<SharedSolve* const> all);

  std::shared_ptr<const petsc::Matrix> R_;
  Mat M_;
  Lockstep* lockstep_ = nullptr;
  int size_ = 0; ///< of a block; 0 before the first unite()
  Copy whole_R_, whole_M_;
  SideBySide x_, w_, r_;
};

} // namespace signorini
