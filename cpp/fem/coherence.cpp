// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/coherence.h"
#include "base/collective.h"
#include <algorithm>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/mesh/Mesh.h>
#include <limits>
#include <map>
#include <numeric>
#include <span>

namespace signorini::fem {

namespace {

/// Disjoint sets of the numbers 0 … n − 1 (union-find); initially each number is a set of its own.
class Sets {
public:
  explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  [[nodiscard]] std::size_t first(std::size_t i) { // least number of the set of i
    while (parent_[i] != i)
      i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::size_t i, std::size_t j) {
    i = first(i), j = first(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

private:
  std::vector<std::size_t> parent_;
};

} // namespace

ConnectedParts connected_parts(const Space& space) {
  const auto dofmap = space.dolfinx()->dofmap();
  const std::vector<std::int64_t> global = space.global_nodes();
  Sets here(global.size());
  for (std::int32_t cell : space.mesh().owned_cells()) {
    const auto nodes = dofmap->cell_dofs(cell);
    for (std::int32_t node : nodes)
      here.unite(static_cast<std::size_t>(nodes[0]), static_cast<std::size_t>(node));
  }
  // Local sets are named by the global number of their first node; those that share a node are joined.
  using Pair = std::array<std::int64_t, 2>;
  const auto owned = static_cast<std::size_t>(space.owned_nodes());
  std::vector<Pair> joined;
  std::vector<std::int64_t> ghosts(global.begin() + static_cast<std::ptrdiff_t>(owned), global.end());
  for (std::size_t i = 0; i < global.size(); ++i)
    if (i >= owned || here.first(i) == i)
      joined.push_back({global[i], global[here.first(i)]});
  ghosts = gather(space.comm(), ghosts);
  const std::int64_t begin = space.first_dof() / space.dim();
  for (std::int64_t ghost : ghosts)
    if (ghost >= begin && ghost < begin + static_cast<std::int64_t>(owned))
      joined.push_back({ghost, global[here.first(static_cast<std::size_t>(ghost - begin))]});
  joined = gather(space.comm(), joined);
  std::map<std::int64_t, std::size_t> number;
  for (const Pair& pair : joined)
    for (std::int64_t node : pair)
      number.emplace(node, number.size());
  Sets all(number.size());
  for (const auto& [a, b] : joined)
    all.unite(number.at(a), number.at(b));
  ConnectedParts parts;
  std::vector<int> of_set(number.size());
  for (std::size_t i = 0; i < number.size(); ++i)
    of_set[i] = all.first(i) == i ? parts.count++ : of_set[all.first(i)];
  const auto part_of = [&](std::size_t node) { return of_set[number.at(global[here.first(node)])]; };
  for (std::size_t i = 0; i < owned; ++i)
    parts.of_node.push_back(part_of(i));
  for (const std::int32_t cell : space.mesh().owned_cells())
    parts.of_cell.push_back(part_of(static_cast<std::size_t>(dofmap->cell_dofs(cell)[0])));
  return parts;
}

double longest_side(const Space& space) {
  const ConnectedParts parts = connected_parts(space);
  // Of each part and component: the least coordinate, and the greatest one with a minus.
  std::vector<double> bounds(6 * static_cast<std::size_t>(parts.count),
                             std::numeric_limits<double>::infinity());
  for (std::size_t node = 0; node < parts.of_node.size(); ++node)
    for (std::size_t c = 0; c < 3; ++c) {
      double* of_part = &bounds[6 * static_cast<std::size_t>(parts.of_node[node])];
      const double x = space.points()[3 * node + c];
      of_part[c] = std::min(of_part[c], x);
      of_part[3 + c] = std::min(of_part[3 + c], -x);
    }
  MPI_Allreduce(MPI_IN_PLACE, bounds.data(), static_cast<int>(bounds.size()), MPI_DOUBLE, MPI_MIN,
                space.comm());
  double longest = 0;
  for (std::size_t i = 0; i < bounds.size(); i += 6)
    for (std::size_t c = 0; c < 3; ++c)
      longest = std::max(longest, -bounds[i + 3 + c] - bounds[i + c]);
  return longest;
}

} // namespace signorini::fem
