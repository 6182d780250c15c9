// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/box_search.h"
#include "base/dolfinx_versions.h"
#include <algorithm>
#include <dolfinx/geometry/utils.h>
#include <optional>

namespace signorini::contact {

namespace {

/// Tree of bounding boxes. dolfinx makes trees of the cells of a mesh: here of the boxes' diagonals, which
/// further cells join to one line, since dolfinx orders a mesh of many parts in quadratic time.
class BoxTree {
public:
  explicit BoxTree(const std::vector<Box>& all) : diagonals_(mesh_of(all)) {
    const auto& numbers = diagonals_.topology()->original_cell_index;
    if constexpr (requires { numbers[0][0]; })
      number_.assign(numbers.front().begin(), numbers.front().end());
    else
      number_.assign(numbers.begin(), numbers.end());
    std::vector<std::int32_t> cells;
    for (std::size_t i = 0; i < number_.size(); ++i)
      if (number_[i] < static_cast<std::int64_t>(all.size()))
        cells.push_back(static_cast<std::int32_t>(i));
    tree_.emplace(dolfinx_versions::bounding_boxes(diagonals_, 1, std::span<const std::int32_t>(cells)));
  }

  /// Returns for each of these boxes the numbers of the other boxes that it overlaps, ascending.
  [[nodiscard]] std::vector<std::vector<std::size_t>> overlaps(const BoxTree& others) const {
    std::vector<std::vector<std::size_t>> found((number_.size() + 1) / 2);
    const std::vector<std::int32_t> pairs = dolfinx::geometry::compute_collisions(*tree_, *others.tree_);
    for (std::size_t i = 0; i + 1 < pairs.size(); i += 2)
      found[number(pairs[i])].push_back(others.number(pairs[i + 1]));
    for (std::vector<std::size_t>& each : found)
      std::ranges::sort(each);
    return found;
  }

private:
  static dolfinx::mesh::Mesh<double> mesh_of(const std::vector<Box>& all) {
    std::vector<double> x;
    std::vector<std::int64_t> cells;
    for (const Box& one : all)
      for (const std::array<double, 3>& end : {one.low, one.high}) {
        x.insert(x.end(), end.begin(), end.end());
        cells.push_back(static_cast<std::int64_t>(cells.size()));
      }
    for (std::int64_t end = 1; end + 1 < static_cast<std::int64_t>(2 * all.size()); end += 2)
      cells.insert(cells.end(), {end, end + 1});
    const dolfinx::fem::CoordinateElement<double> element(dolfinx::mesh::CellType::interval, 1);
    return dolfinx_versions::create_mesh(MPI_COMM_SELF, MPI_COMM_SELF, std::span<const std::int64_t>(cells),
                                         element, x, {2 * all.size(), 3}, false);
  }
  [[nodiscard]] std::size_t number(std::int32_t cell) const {
    return static_cast<std::size_t>(number_[static_cast<std::size_t>(cell)]);
  }

  dolfinx::mesh::Mesh<double> diagonals_;
  std::vector<std::int64_t>
      number_; ///< number of each cell's box; larger ones are of cells between two boxes
  std::optional<dolfinx::geometry::BoundingBoxTree<double>> tree_;
};

} // namespace

std::vector<std::vector<std::size_t>> overlaps(const std::vector<Box>& boxes,
                                               const std::vector<Box>& others) {
  return BoxTree(boxes).overlaps(BoxTree(others));
}

} // namespace signorini::contact
