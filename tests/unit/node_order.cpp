// SPDX-License-Identifier: GPL-3.0-or-later
// The order of nodes in space.
#include "fem/node_order.h"
#include "fixtures.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <dolfinx/fem/FunctionSpace.h>
#include <numeric>
#include <random>
#include <set>

using namespace signorini;

namespace {

using Links = std::vector<std::set<std::int32_t>>;

std::vector<int> order(const Links& links) {
  return fem::breadth_first_order(dolfinx::graph::AdjacencyList<std::int32_t>(links));
}

/// Largest difference of the numbers of linked nodes.
int bandwidth(const Links& links, const std::vector<int>& number) {
  int width = 0;
  for (std::size_t i = 0; i < links.size(); ++i)
    for (const std::int32_t j : links[i])
      width = std::max(width, std::abs(number[i] - number[static_cast<std::size_t>(j)]));
  return width;
}

/// Bars of nx × ny nodes, unconnected, whose nodes are linked with the next ones in both directions and have
/// random numbers.
Links bars(int count, int nx, int ny) {
  std::vector<std::int32_t> place(static_cast<std::size_t>(count) * nx * ny);
  std::iota(place.begin(), place.end(), 0);
  std::ranges::shuffle(place, std::mt19937(1));
  Links links(place.size());
  const auto at = [&](int bar, int i, int j) {
    return place[(static_cast<std::size_t>(bar) * nx + i) * ny + j];
  };
  const auto link = [&](std::int32_t i, std::int32_t j) {
    links[static_cast<std::size_t>(i)].insert(j);
    links[static_cast<std::size_t>(j)].insert(i);
  };
  for (int bar = 0; bar < count; ++bar)
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < ny; ++j) {
        if (i + 1 < nx)
          link(at(bar, i, j), at(bar, i + 1, j));
        if (j + 1 < ny)
          link(at(bar, i, j), at(bar, i, j + 1));
      }
  return links;
}

/// Whether the numbers 0, 1, … of nodes are those of breadth-first searches: the first neighbours of the
/// nodes of a component ascend.
bool breadth_first(const Links& links) {
  std::int32_t last = 0;
  for (std::int32_t i = 0; const std::set<std::int32_t>& neighbours : links) {
    const std::int32_t first = neighbours.empty() ? i : std::min(i, *neighbours.begin());
    if (first < last)
      return false;
    last = first;
    ++i;
  }
  return true;
}

/// Links between the nodes that this rank owns, by its cells.
Links links_of(const fem::Space& space) {
  Links links(static_cast<std::size_t>(space.owned_nodes()));
  const auto dofmap = space.dolfinx()->dofmap();
  for (const std::int32_t cell : space.mesh().owned_cells())
    for (const std::int32_t i : dofmap->cell_dofs(cell))
      for (const std::int32_t j : dofmap->cell_dofs(cell))
        if (i != j && i < space.owned_nodes() && j < space.owned_nodes())
          links[static_cast<std::size_t>(i)].insert(j);
  return links;
}

} // namespace

TEST_CASE("breadth-first searches number every node once, along the longest extent", "[fem]") {
  const int count = GENERATE(1, 3), width = GENERATE(1, 4);
  CAPTURE(count, width);
  const Links links = bars(count, 50, width);
  std::vector<int> number = order(links);
  CHECK(bandwidth(links, number) < 2 * width); // neighbours are in one layer or two, of `width` nodes at most
  Links renumbered(links.size());
  for (std::size_t i = 0; i < links.size(); ++i)
    for (const std::int32_t j : links[i])
      renumbered[static_cast<std::size_t>(number[i])].insert(number[static_cast<std::size_t>(j)]);
  CHECK(breadth_first(renumbered));
  std::ranges::sort(number);
  std::vector<int> all(links.size());
  std::iota(all.begin(), all.end(), 0);
  CHECK(number == all);
  CHECK(order({}).empty());
  CHECK(order({{}, {}}) == std::vector{0, 1}); // nodes without links
}

TEST_CASE("in space nodes are numbered by breadth-first searches", "[fem]") {
  const char* file = GENERATE("tests/data/cube.toml", "tests/data/two-cubes.toml", "tests/data/block.toml");
  const int degree = GENERATE(1, 2);
  CAPTURE(file, degree);
  const scene::Scene scene = test::parse(test::source(file));
  const fem::Space space(test::discretised(scene)->mesh, degree);
  const bool found = test::total(!breadth_first(links_of(space))) == 0;
  CHECK(found == (space.dim() == 3));
}
