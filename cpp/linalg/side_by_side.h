// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/supernodal.h"
#include <span>
#include <vector>

namespace signorini {

/// Storage of several right-hand sides whose values of one unknown are side by side, in groups as
/// TriangularSolves takes them. Lanes without right-hand side are zero.
class SideBySide {
public:
  /// Makes room for `count` right-hand sides of n values, whose values are undefined.
  void resize(std::size_t n, std::size_t count);
  [[nodiscard]] std::span<const TriangularSolves::LaneGroup> groups() const { return groups_; }

  /// Values of one right-hand side.
  struct Column {
    double* first;
    std::size_t stride;
    [[nodiscard]] double& operator[](std::size_t i) const { return first[i * stride]; }
  };
  [[nodiscard]] std::size_t bytes() const { return values_.capacity() * sizeof(double); }
  /// Returns right-hand side number i.
  [[nodiscard]] Column column(std::size_t i) const;

private:
  std::vector<double> values_;
  std::vector<TriangularSolves::LaneGroup> groups_;
};

} // namespace signorini
