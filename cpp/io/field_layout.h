// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <cstdint>

namespace signorini::io {

/// What the values of a stored field are: vectors at the nodes or in the cells, and values of other shapes.
enum class Values { nodal, cellwise, nodal_scalar, cellwise_scalar, cellwise_tensor };

/// Whether a field has a value for each cell, else for each node.
[[nodiscard]] bool in_cells(Values values);

/// The shape of a stored value: vectors have 3 components in the plane too, tensors 3 × 3.
[[nodiscard]] std::vector<std::size_t> stored_shape(Values values);

/// Its number of entries.
[[nodiscard]] std::size_t stored_components(Values values);

/// The mesh as field files have it, nodes and cells in the order of the ranks, and the values of fields in
/// that order, on rank 0. Its nodes are the mesh's own: of degree 2 the vertices.
class FieldLayout {
public:
  /// Collective. `space` must outlive this object.
  explicit FieldLayout(const fem::Space& space);

  /// On all ranks together.
  [[nodiscard]] std::size_t nodes() const { return nodes_.total(); }
  [[nodiscard]] std::size_t cells() const { return cells_.total(); }
  [[nodiscard]] std::size_t rows(Values values) const { return in_cells(values) ? cells() : nodes(); }

  /// Coordinates (nodes × dim), m, and the nodes of each cell (cells × (dim + 1)); empty but on rank 0.
  /// Collective.
  [[nodiscard]] std::vector<double> points() const;
  [[nodiscard]] std::vector<std::int64_t> topology() const;

  /// Brings together the values that each rank owns, at the nodes of V or in the cells, as rows (rows ×
  /// stored_components); valid on rank 0 until the next call. Collective.
  [[nodiscard]] std::span<const double> gather(Values values, std::span<const double> owned);

private:
  /// Nodes or cells: `own` are the places of this rank's rows among the values that it owns.
  struct Rows {
    std::vector<std::size_t> own;
    std::vector<int> counts, starts; ///< of each rank
    [[nodiscard]] std::size_t total() const {
      return static_cast<std::size_t>(starts.back()) + static_cast<std::size_t>(counts.back());
    }
  };
  /// Collective.
  [[nodiscard]] Rows rows_of(std::vector<std::size_t> own) const;
  /// Rows of `columns` entries each. Collective.
  template <class T>
  void gather(const Rows& rows, std::size_t columns, const std::vector<T>& mine, std::vector<T>& all) const;

  const fem::Space& space_;
  Rows nodes_, cells_;
  std::vector<double> mine_, all_; ///< buffers
};

} // namespace signorini::io
