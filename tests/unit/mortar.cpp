// SPDX-License-Identifier: GPL-3.0-or-later
// Rows of contact between two surfaces: what dual mortar promises, on meshes that do not match.
#include "contact/mortar.h"
#include "base/error.h"
#include "base/petsc.h"
#include <algorithm>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <functional>
#include <numbers>

using namespace signorini;
using contact::MortarRow;
using fem::SurfaceMesh;
using Point = std::array<double, 3>;

namespace {

constexpr double rounding = 1e-13;

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Point& a) { return std::hypot(a[0], a[1], a[2]); }

/// A line of facets through points, whose normals are to the right of the line.
SurfaceMesh line(const std::vector<Point>& points) {
  SurfaceMesh made;
  for (const Point& x : points)
    made.vertices.push_back({x, static_cast<PetscInt>(2 * made.vertices.size())});
  for (int i = 0; i + 1 < static_cast<int>(points.size()); ++i) {
    const Point way = minus(points[static_cast<std::size_t>(i) + 1], points[static_cast<std::size_t>(i)]);
    made.facets.push_back({{i, i + 1, -1}, {way[1] / length(way), -way[0] / length(way), 0}});
  }
  return made;
}

/// Triangles over the unit square with `side` squares along a side, moved within it by uneven amounts and
/// mapped; `up`: whether normals point along +z before the map.
SurfaceMesh sheet(int side, bool up, const std::function<Point(double, double)>& map) {
  SurfaceMesh made;
  for (int i = 0; i <= side; ++i)
    for (int j = 0; j <= side; ++j) {
      double x = i / static_cast<double>(side), y = j / static_cast<double>(side);
      const double move = 0.2 / side * std::sin(3.0 * i + 5.0 * j) * (i % side != 0) * (j % side != 0);
      made.vertices.push_back({map(x + move, y - move), static_cast<PetscInt>(3 * made.vertices.size())});
    }
  const auto add = [&](int a, int b, int c) {
    const auto x = [&](int i) { return made.vertices[static_cast<std::size_t>(i)].x; };
    Point normal = cross(minus(x(b), x(a)), minus(x(c), x(a)));
    const double size = (up ? 1 : -1) * length(normal);
    for (double& component : normal)
      component /= size;
    made.facets.push_back({{a, b, c}, normal});
  };
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const int at = i * (side + 1) + j;
      add(at, at + side + 1, at + 1);
      add(at + 1, at + side + 1, at + side + 2);
    }
  return made;
}

/// ∫ φ_j over a surface.
std::vector<double> areas(const SurfaceMesh& surface, int dim) {
  std::vector<double> sums(surface.vertices.size());
  for (const SurfaceMesh::Facet& facet : surface.facets) {
    const auto x = [&](std::size_t i) {
      return surface.vertices[static_cast<std::size_t>(facet.vertices[i])].x;
    };
    const double size =
        dim == 2 ? length(minus(x(1), x(0))) : length(cross(minus(x(1), x(0)), minus(x(2), x(0)))) / 2;
    for (std::size_t i = 0; i < static_cast<std::size_t>(dim); ++i)
      sums[static_cast<std::size_t>(facet.vertices[i])] += size / dim;
  }
  return sums;
}

std::vector<Point> along(int facets, const std::function<Point(double)>& at) {
  std::vector<Point> points;
  for (int i = 0; i <= facets; ++i) // uneven
    points.push_back(
        at(i / static_cast<double>(facets) + 0.2 / facets * std::sin(2.0 * i) * (i > 0) * (i < facets)));
  return points;
}

/// Flat surfaces, the slave at height 0 with its normals up, the master `gap` above it, both over all of a
/// unit line or square.
struct Flat {
  SurfaceMesh slave, master;
  int dim;
};
Flat flat(int dim, int on_slave, int on_master, double gap) {
  if (dim == 2)
    return {line(along(on_slave, [](double s) { return Point{1 - s, 0, 0}; })),
            line(along(on_master, [&](double s) { return Point{s, gap, 0}; })), 2};
  return {sheet(on_slave, true, [](double x, double y) { return Point{x, y, 0}; }),
          sheet(on_master, false, [&](double x, double y) { return Point{x, y, gap}; }), 3};
}

/// Requires that a row reproduces translations, and that its force has no moment with that on the masters.
void require_balance(const MortarRow& row, const SurfaceMesh& slave, const SurfaceMesh& master) {
  double sum = 0;
  Point opposite{};
  for (const auto& [vertex, weight] : row.master) {
    sum += weight;
    for (std::size_t c = 0; c < 3; ++c)
      opposite[c] += weight * master.vertices[static_cast<std::size_t>(vertex)].x[c];
  }
  CHECK(std::abs(sum - 1) < rounding);
  CHECK(std::abs(length(row.nu) - 1) < rounding);
  const Point gap = minus(opposite, slave.vertices[static_cast<std::size_t>(row.vertex)].x);
  CHECK(length(cross(gap, row.nu)) < rounding);
  CHECK(std::abs(gap[0] * row.nu[0] + gap[1] * row.nu[1] + gap[2] * row.nu[2] - row.gap) < rounding);
}

} // namespace

TEST_CASE("dual mortar passes the patch test on meshes that do not match", "[contact][mortar]") {
  const int dim = GENERATE(2, 3);
  const auto [on_slave, on_master] =
      GENERATE(std::pair(5, 7), std::pair(7, 5), std::pair(3, 8), std::pair(4, 4));
  CAPTURE(dim, on_slave, on_master);
  const double gap = 0.05;
  const Flat pair = flat(dim, on_slave, on_master, gap);
  const std::vector<MortarRow> rows = contact::mortar_rows(pair.slave, pair.master, dim, false, "contact");
  REQUIRE(rows.size() == pair.slave.vertices.size());
  // A uniform pressure p acts on the slave with p W_i, on the master with Σ W_i C_ij p: both are ∫ φ p.
  const std::vector<double> of_slave = areas(pair.slave, dim), of_master = areas(pair.master, dim);
  std::vector<double> on_masters(of_master.size());
  for (const MortarRow& row : rows) {
    require_balance(row, pair.slave, pair.master);
    CHECK(std::abs(row.gap - gap) < rounding);
    CHECK(std::abs(row.area - of_slave[static_cast<std::size_t>(row.vertex)]) < rounding);
    for (const auto& [vertex, weight] : row.master)
      on_masters[static_cast<std::size_t>(vertex)] += row.area * weight;
  }
  for (std::size_t j = 0; j < of_master.size(); ++j)
    CHECK(std::abs(on_masters[j] - of_master[j]) < rounding);
}

/// The surface with midpoints, for functions of degree 2.
SurfaceMesh quadratic(SurfaceMesh surface, int dim) {
  for (SurfaceMesh::Facet& facet : surface.facets)
    for (std::size_t edge = 0; edge < (dim == 2 ? 1 : 3); ++edge) {
      std::array<int, 2> ends{facet.vertices[edge],
                              facet.vertices[(edge + 1) % static_cast<std::size_t>(dim)]};
      std::ranges::sort(ends);
      const auto found = std::ranges::find(surface.midpoints, ends, &SurfaceMesh::Midpoint::ends);
      facet.midpoints[edge] =
          static_cast<int>(surface.vertices.size()) + static_cast<int>(found - surface.midpoints.begin());
      if (found != surface.midpoints.end())
        continue;
      const Point &a = surface.node(ends[0]).x, &b = surface.node(ends[1]).x;
      surface.midpoints.push_back({{{(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2}, 0}, ends});
    }
  return surface;
}

/// ∫ φ_j over a surface of degree 2, by its hat functions.
std::vector<double> quadratic_areas(const SurfaceMesh& surface, int dim) {
  const std::vector<double> hats = areas(surface, dim);
  std::vector<double> sums(static_cast<std::size_t>(surface.nodes()));
  for (std::size_t i = 0; i < hats.size(); ++i)
    sums[i] = dim == 2 ? hats[i] / 3 : 0; // Simpson's rule; in space midpoints alone
  for (const SurfaceMesh::Facet& facet : surface.facets) {
    const Point a = surface.node(facet.vertices[0]).x, b = surface.node(facet.vertices[1]).x;
    const double size = dim == 2
                            ? length(minus(b, a))
                            : length(cross(minus(b, a), minus(surface.node(facet.vertices[2]).x, a))) / 2;
    for (std::size_t edge = 0; edge < (dim == 2 ? 1 : 3); ++edge)
      sums[static_cast<std::size_t>(facet.midpoints[edge])] += size * (dim == 2 ? 2.0 / 3 : 1.0 / 3);
  }
  return sums;
}

TEST_CASE("dual mortar of degree 2 passes the patch test, and its rows see one hat function each",
          "[contact][mortar]") {
  const int dim = GENERATE(2, 3);
  const auto [on_slave, on_master] = GENERATE(std::pair(5, 7), std::pair(7, 5), std::pair(4, 4));
  CAPTURE(dim, on_slave, on_master);
  constexpr double gap = 0.05;
  const Flat pair = flat(dim, on_slave, on_master, gap);
  const SurfaceMesh slave = quadratic(pair.slave, dim), master = quadratic(pair.master, dim);
  const std::vector<MortarRow> rows = contact::mortar_rows(slave, master, dim, false, "contact");
  REQUIRE(rows.size() == slave.vertices.size());
  const std::vector<double> of_slave = quadratic_areas(slave, dim), of_master = quadratic_areas(master, dim);
  std::vector<double> on_slaves(of_slave.size()), on_masters(of_master.size());
  bool beyond_own = false;
  for (const MortarRow& row : rows) {
    CHECK(std::abs(row.gap - gap) < rounding);
    for (const auto& [node, weight] : row.master)
      on_masters[static_cast<std::size_t>(node)] += row.area * weight;
    on_slaves[static_cast<std::size_t>(row.vertex)] += row.area * row.own;
    std::vector<double> B(of_slave.size());
    B[static_cast<std::size_t>(row.vertex)] = row.own;
    for (const auto& [node, weight] : row.slave) {
      on_slaves[static_cast<std::size_t>(node)] += row.area * weight;
      B[static_cast<std::size_t>(node)] = weight;
      beyond_own = beyond_own || std::abs(weight) > 0.1;
    }
    for (std::size_t vertex = 0; vertex < slave.vertices.size(); ++vertex) {
      double hat = B[vertex];
      for (std::size_t i = 0; i < slave.midpoints.size(); ++i)
        for (const int end : slave.midpoints[i].ends)
          hat += end == static_cast<int>(vertex) ? B[slave.vertices.size() + i] / 2 : 0;
      CHECK(std::abs(hat - (static_cast<int>(vertex) == row.vertex ? 1 : 0)) < rounding);
    }
  }
  CHECK(beyond_own);
  for (std::size_t j = 0; j < of_slave.size(); ++j)
    CHECK(std::abs(on_slaves[j] - of_slave[j]) < rounding);
  for (std::size_t j = 0; j < of_master.size(); ++j)
    CHECK(std::abs(on_masters[j] - of_master[j]) < rounding);
}

TEST_CASE("rows between curved surfaces conserve linear and angular momentum", "[contact][mortar]") {
  const int dim = GENERATE(2, 3);
  CAPTURE(dim);
  constexpr double R = 1.3, gap = 0.01;
  const SurfaceMesh slave = dim == 2 ? line(along(9,
                                                  [](double s) {
                                                    return Point{R * std::sin(0.4 * (1 - 2 * s)),
                                                                 R * std::cos(0.4 * (1 - 2 * s)) - R, 0};
                                                  }))
                                     : sheet(5, true, [](double x, double y) {
                                         const double r = (x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5);
                                         return Point{x, y, std::sqrt(R * R - r) - R};
                                       });
  const SurfaceMesh master =
      dim == 2 ? line(along(7,
                            [](double s) {
                              return Point{2 * R * std::sin(0.3 * (2 * s - 1)),
                                           gap + 2 * R * (1 - std::cos(0.3 * (2 * s - 1))), 0};
                            }))
               : sheet(7, false, [](double x, double y) {
                   const double r = (x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5);
                   return Point{x, y, gap + 2 * R - std::sqrt(4 * R * R - r)};
                 });
  const std::vector<MortarRow> rows = contact::mortar_rows(slave, master, dim, false, "contact");
  REQUIRE(rows.size() > slave.vertices.size() / 2);
  double least = 1;
  for (const MortarRow& row : rows) {
    require_balance(row, slave, master);
    least = std::min(least, row.gap);
  }
  CHECK(least > 0);
  CHECK(least < 2 * gap);
}

TEST_CASE("the part of a slave facet that the master covers is integrated alone", "[contact][mortar]") {
  const double covered = GENERATE(0.5, 0.31, 1e-3);
  CAPTURE(covered);
  const Flat pair = flat(2, 4, 3, 0.1);
  const SurfaceMesh master =
      line(along(3, [&](double s) { return Point{(1 - covered) + s * (covered + 0.4), 0.1, 0}; }));
  const std::vector<MortarRow> rows = contact::mortar_rows(pair.slave, master, 2, false, "contact");
  double area = 0;
  for (const MortarRow& row : rows) {
    area += row.area;
    CHECK(row.area > 0);
    CHECK(std::abs(row.gap - 0.1) < 1e-9); // the dual functions of a narrow strip lose digits
    double sum = 0;
    for (const auto& [vertex, weight] : row.master)
      sum += weight;
    CHECK(std::abs(sum - 1) < rounding);
  }
  CHECK(std::abs(area - covered) < 1e-12);
}

TEST_CASE("a body of revolution has rings in place of lengths", "[contact][mortar]") {
  const Flat pair = flat(2, 5, 7, 0.1);
  const std::vector<MortarRow> rows = contact::mortar_rows(pair.slave, pair.master, 2, true, "contact");
  double area = 0;
  for (const MortarRow& row : rows) {
    area += row.area;
    require_balance(row, pair.slave, pair.master);
  }
  CHECK(std::abs(area - std::numbers::pi) < 1e-12); // of a disc of radius 1
}

TEST_CASE("surfaces that do not face each other have no rows", "[contact][mortar]") {
  const Flat pair = flat(2, 4, 4, 0.1);
  SurfaceMesh turned = pair.master;
  for (SurfaceMesh::Facet& facet : turned.facets)
    facet.normal[1] *= -1;
  CHECK(contact::mortar_rows(pair.slave, turned, 2, false, "contact").empty());
  SurfaceMesh beside = pair.master;
  for (SurfaceMesh::Vertex& vertex : beside.vertices)
    vertex.x[0] += 3;
  CHECK(contact::mortar_rows(pair.slave, beside, 2, false, "contact").empty());
}

TEST_CASE("master surfaces behind each other are refused", "[contact][mortar]") {
  const Flat pair = flat(2, 4, 4, 0.1);
  SurfaceMesh both = pair.master;
  const int first = static_cast<int>(both.vertices.size());
  for (const SurfaceMesh::Vertex& vertex : pair.master.vertices)
    both.vertices.push_back({{vertex.x[0], vertex.x[1] + 0.5, 0}, vertex.first_dof + 100});
  for (SurfaceMesh::Facet facet : pair.master.facets) {
    facet.vertices = {facet.vertices[0] + first, facet.vertices[1] + first, -1};
    both.facets.push_back(facet);
  }
  CHECK_THROWS_MATCHES(
      contact::mortar_rows(pair.slave, both, 2, false, "contact"), UserError,
      Catch::Matchers::MessageMatches(Catch::Matchers::ContainsSubstring("contact: seen from the node at")));
}
