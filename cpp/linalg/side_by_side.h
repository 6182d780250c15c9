// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/lane_kernels.h"
#include <span>
#include <vector>

namespace signorini {

/// Storage of several right-hand sides whose values of one unknown are side by side, in groups as
/// TriangularSolves takes them. Lanes without right-hand side are zero.
class SideBySide {
public:
  /// Makes room for `count` right-hand sides of n values, whose values are undefined.
  void resize(std::size_t n, std::size_t count);
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::span<const LaneGroup> groups() const { return groups_; }

  /// Sets all right-hand sides: value i of number k becomes from[k][order[i]]; from[k][i] if `order` is null.
  void gather(std::span<const double* const> from, const int* order);
  /// Copies all right-hand sides: value i of number k to to[k][order[i]].
  void scatter(const int* order, std::span<double* const> to) const;
  /// Copies all values of `other`, which has the same size.
  void copy(const SideBySide& other);

  /// Values of one right-hand side.
  struct Column {
    double* first;
    std::size_t stride;
    [[nodiscard]] double& operator[](std::size_t i) const { return first[i * stride]; }
  };
  /// Returns right-hand side number i.
  [[nodiscard]] Column column(std::size_t i) const;
  /// Copies right-hand side number i of `other`, which has as many values, to number `to`.
  void copy_column(const SideBySide& other, std::size_t i, std::size_t to);

  [[nodiscard]] std::size_t bytes() const { return values_.capacity() * sizeof(double); }

private:
  std::size_t n_ = 0, count_ = 0;
  std::vector<double> values_;
  std::vector<LaneGroup> groups_;
};

} // namespace signorini
