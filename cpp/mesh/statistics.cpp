// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/statistics.h"
#include "mesh/facets.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <span>

namespace signorini::mesh {

namespace {

/// Sets of connected points.
class Union {
public:
  explicit Union(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i)
      i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) { parent_[root(a)] = root(b); }

private:
  std::vector<std::size_t> parent_;
};

class Measuring {
public:
  explicit Measuring(const RawMesh& mesh) : mesh_(mesh), dim_(static_cast<std::size_t>(mesh.dim)) {}

  /// Length, area or volume of the simplex with these vertices.
  [[nodiscard]] double measure(std::span<const std::int64_t> nodes) const {
    const Point a = edge(nodes, 1);
    if (nodes.size() == 2)
      return length(a);
    const Point normal = cross(a, edge(nodes, 2));
    return nodes.size() == 3 ? length(normal) / 2 : std::abs(dot(normal, edge(nodes, 3))) / 6;
  }

  /// Ratio of the radii of the inscribed and the circumscribed circle or sphere of a cell, times dim.
  [[nodiscard]] double quality(std::span<const std::int64_t> cell) const {
    double surface = 0;
    std::vector<std::int64_t> facet;
    for (std::size_t left_out = 0; left_out <= dim_; ++left_out) {
      facet.assign(cell.begin(), cell.end());
      facet.erase(facet.begin() + static_cast<std::ptrdiff_t>(left_out));
      surface += measure(facet);
    }
    const double inscribed = static_cast<double>(dim_) * measure(cell) / surface;
    return static_cast<double>(dim_) * inscribed / circumscribed(cell);
  }

  [[nodiscard]] Point centre(std::span<const std::int64_t> nodes) const {
    Point sum{};
    for (const std::int64_t node : nodes)
      sum = along(sum, 1 / static_cast<double>(nodes.size()), point(node));
    return sum;
  }

  [[nodiscard]] Point point(std::int64_t node) const {
    const double* x = &mesh_.points[3 * static_cast<std::size_t>(node)];
    return {x[0], x[1], x[2]};
  }

  [[nodiscard]] Statistics::Group group(const std::string& name, std::size_t vertices,
                                        const std::vector<std::int64_t>& nodes) const {
    Statistics::Group found{.name = name, .elements = nodes.size() / vertices, .measure = 0, .centre = {}};
    for (std::size_t first = 0; first < nodes.size(); first += vertices) {
      const std::span own = std::span(nodes).subspan(first, vertices);
      const double size = measure(own);
      found.measure += size;
      found.centre = along(found.centre, size, centre(own));
    }
    if (found.measure > 0)
      found.centre = scaled(1 / found.measure, found.centre);
    return found;
  }

private:
  [[nodiscard]] Point edge(std::span<const std::int64_t> nodes, std::size_t end) const {
    return from(point(nodes[0]), point(nodes[end]));
  }

  [[nodiscard]] double circumscribed(std::span<const std::int64_t> cell) const {
    const Point a = edge(cell, 1), b = edge(cell, 2);
    if (dim_ == 2)
      return length(a) * length(b) * length(from(a, b)) / (4 * measure(cell));
    const Point c = edge(cell, 3);
    const Point sum =
        along(along(scaled(dot(a, a), cross(b, c)), dot(b, b), cross(c, a)), dot(c, c), cross(a, b));
    return length(sum) / (12 * measure(cell));
  }

  const RawMesh& mesh_;
  std::size_t dim_;
};

} // namespace

Statistics statistics(const RawMesh& mesh) {
  const Measuring measuring(mesh);
  const std::size_t corners = static_cast<std::size_t>(mesh.dim) + 1, nodes = mesh.points.size() / 3,
                    count = mesh.cells.size() / corners;
  Statistics all;
  all.low.fill(std::numeric_limits<double>::infinity());
  all.high.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    all.low[i % 3] = std::min(all.low[i % 3], mesh.points[i]);
    all.high[i % 3] = std::max(all.high[i % 3], mesh.points[i]);
  }
  Union parts(nodes);
  all.shortest = std::numeric_limits<double>::infinity();
  for (std::size_t first = 0; first < mesh.cells.size(); first += corners) {
    const std::span cell = std::span(mesh.cells).subspan(first, corners);
    for (std::size_t i = 0; i < corners; ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const std::array ends{cell[i], cell[j]};
        const double length = measuring.measure(ends);
        all.shortest = std::min(all.shortest, length);
        all.longest = std::max(all.longest, length);
        parts.join(static_cast<std::size_t>(cell[i]), static_cast<std::size_t>(cell[j]));
      }
    const double quality = measuring.quality(cell);
    all.least_quality = std::min(all.least_quality, quality);
    all.quality += quality / static_cast<double>(count);
    all.poor += quality < Statistics::poor_quality;
  }
  std::set<std::size_t> roots;
  for (std::size_t node = 0; node < nodes; ++node)
    roots.insert(parts.root(node));
  all.connected = roots.size();
  for (const auto& [name, ranges] : mesh.parts) {
    std::vector<std::int64_t> own;
    for (std::size_t r = 0; r < ranges.size(); r += 2)
      own.insert(own.end(), mesh.cells.begin() + ranges[r] * static_cast<std::ptrdiff_t>(corners),
                 mesh.cells.begin() + ranges[r + 1] * static_cast<std::ptrdiff_t>(corners));
    all.cells.push_back(measuring.group(name, corners, own));
  }
  const std::vector<Facet> outer = outer_facets(sorted_facets(mesh.dim, mesh.cells));
  for (const auto& [name, facets] : mesh.facets) {
    Statistics::Group& group = all.facets.emplace_back(measuring.group(name, corners - 1, facets));
    for (std::size_t first = 0; first < facets.size(); first += corners - 1)
      group.inside += !std::ranges::binary_search(
          outer, sorted_nodes(std::span(facets).subspan(first, corners - 1)), {}, &Facet::nodes);
  }
  return all;
}

} // namespace signorini::mesh
