// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/collective.h"
#include "base/error.h"
#include "base/subprocess.h"
#include "fem/space.h"
#include "fixtures.h"
#include "mesh/gmsh_process.h"
#include "mesh/refinement.h"
#include "mesh/size_field.h"
#include <array>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <fmt/format.h>
#include <fstream>
#include <numbers>
#include <set>
#include <unistd.h>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;

namespace {

constexpr double radius = 15, cap = std::numbers::pi / 6; // of meshes/half-ball.geo, m and rad

scene::Mesh half_ball(double size) {
  return test::parse(test::source("scenes/half-ball.toml"), {"mesh.size=" + std::to_string(size)}).mesh;
}

/// Length, area or volume of a simplex of `dim` dimensions in space, from the Gram determinant of its edges.
double measure(const mesh::RawMesh& raw, const std::int64_t* nodes, int dim) {
  double G[3][3]{};
  for (int i = 0; i < dim; ++i)
    for (int j = 0; j < dim; ++j)
      for (int c = 0; c < 3; ++c) {
        const double origin = raw.points[3 * nodes[0] + c];
        G[i][j] += (raw.points[3 * nodes[i + 1] + c] - origin) * (raw.points[3 * nodes[j + 1] + c] - origin);
      }
  if (dim == 1)
    return std::sqrt(G[0][0]);
  const double minor = G[0][0] * G[1][1] - G[0][1] * G[1][0];
  if (dim == 2)
    return std::sqrt(minor) / 2;
  return std::sqrt(G[2][2] * minor - G[2][1] * (G[0][0] * G[1][2] - G[0][2] * G[1][0]) +
                   G[2][0] * (G[0][1] * G[1][2] - G[0][2] * G[1][1])) /
         6;
}

double total_measure(const mesh::RawMesh& raw, const std::vector<std::int64_t>& simplices, int dim) {
  double sum = 0;
  for (std::size_t i = 0; i < simplices.size(); i += dim + 1)
    sum += measure(raw, &simplices[i], dim);
  return sum;
}

/// Nodes of the Lagrange functions of a degree on triangles: corners, with degree 2 also edges.
long nodes_of(const std::vector<std::int64_t>& triangles, int degree) {
  std::set<std::pair<std::int64_t, std::int64_t>> nodes;
  for (std::size_t i = 0; i < triangles.size(); i += 3)
    for (int j = 0; j < 3; ++j) {
      const std::int64_t a = triangles[i + j], b = triangles[i + (j + 1) % 3];
      nodes.insert({a, a});
      if (degree == 2)
        nodes.insert(std::minmax(a, b));
    }
  return static_cast<long>(nodes.size());
}

} // namespace

TEST_CASE("boundary groups hold their nodes once, on any number of ranks", "[mesh]") {
  const scene::Scene scene = test::parse(test::source("tests/data/manufactured.toml"));
  const mesh::Mesh mesh(MPI_COMM_WORLD, scene.mesh);
  CHECK(mesh.dim() == 2);
  CHECK(std::abs(mesh.diameter() - std::sqrt(2)) < 1e-14);
  for (int degree : {1, 2}) {
    CAPTURE(degree);
    const fem::Space space(mesh, degree);
    const auto nodes = [&](const char* group) {
      return test::total(static_cast<long>(space.nodes_on(group, "test").size()));
    };
    // A side of length 1 at element size 0.25 has 4 edges, and 3 neighbouring sides share 2 corners.
    const long side = 4 * degree + 1;
    CHECK(nodes("bottom") == side);
    CHECK(nodes("rest") == 3 * side - 2);
    CHECK(nodes("boundary") == 4 * side - 4);
    for (int node : space.nodes_on("bottom", "test"))
      CHECK(std::abs(space.points()[static_cast<std::size_t>(3 * node + 1)]) < 1e-14);
  }
  CHECK_THROWS_WITH(mesh.facets("botom", "clamp.on"),
                    ContainsSubstring("clamp.on") && ContainsSubstring("\"bottom\""));
  CHECK_THROWS_WITH(mesh.facets("body", "clamp.on"), ContainsSubstring("dimension 2"));
}

TEST_CASE("groups of cells and of facets make up the body once, on any number of ranks", "[mesh]") {
  const char* name = GENERATE(as<const char*>{}, "tests/data/parts.geo", "tests/data/parts-space.geo");
  CAPTURE(name);
  const scene::Mesh file{.file = test::source(name), .size = 0.4};
  const mesh::Mesh mesh(MPI_COMM_WORLD, file);
  const auto cells = [&](const char* group) -> const std::vector<std::int32_t>& {
    return mesh.cells(group, "test");
  };
  const long left = test::total(static_cast<long>(cells("left").size())),
             right = test::total(static_cast<long>(cells("right").size()));
  CHECK(left > 0);
  CHECK(right > 0);
  CHECK(left + right == mesh.cells());
  std::vector<std::int32_t> both = cells("left");
  both.insert(both.end(), cells("right").begin(), cells("right").end());
  std::ranges::sort(both);
  CHECK(both == cells("body"));
  const fem::Space space(mesh, 1);
  for (int node : space.nodes_on("interface", "test"))
    CHECK(std::abs(space.points()[static_cast<std::size_t>(3 * node)] - 1) < 1e-14);
  CHECK(mesh.group_dimension("left", "test") == mesh.dim());
  CHECK(mesh.group_dimension("interface", "test") == mesh.dim() - 1);
  const std::string part = mesh.dim() == 2 ? "surface" : "volume",
                    side = mesh.dim() == 2 ? "curve" : "surface";
  CHECK_THROWS_WITH(mesh.cells("lft", "material[1].on"),
                    ContainsSubstring("material[1].on") &&
                        ContainsSubstring("no " + part + " group \"lft\"") &&
                        ContainsSubstring("did you mean \"left\"") &&
                        ContainsSubstring(part + " groups of the file: body, left, right"));
  CHECK_THROWS_WITH(mesh.cells("end", "material.on"),
                    ContainsSubstring("has dimension " + std::to_string(mesh.dim() - 1)));
  CHECK_THROWS_WITH(mesh.group_dimension("interfaces", "control.on"),
                    ContainsSubstring("no " + part + " or " + side + " group \"interfaces\"") &&
                        ContainsSubstring("did you mean \"interface\"") &&
                        ContainsSubstring(side + " groups of the file: bo") &&
                        ContainsSubstring("end, interface, start"));
}

TEST_CASE("a mesh is divided among ranks alike each time, whoever of them is late", "[mesh]") {
  std::vector<double> first;
  for (int again = 0; again < 10; ++again) {
    usleep(static_cast<useconds_t>(2000 * ((again + 2 * rank(MPI_COMM_WORLD)) % 3)));
    const test::Ready ready("scenes/half-disc.toml", {"mesh.size=2"});
    const auto points = ready.problem.space.points();
    const std::vector<double> own(points.begin(), points.end());
    if (first.empty())
      first = own;
    CHECK(own == first);
  }
}

TEST_CASE("volume and surfaces of the half ball converge with the square of the size", "[mesh]") {
  const double cube = std::pow(radius, 3), square = std::pow(radius, 2), pi = std::numbers::pi;
  const std::map<std::string, double> exact{{"top", pi * square},
                                            {"contact", 2 * pi * square * (1 - std::cos(cap))},
                                            {"side", 2 * pi * square * std::cos(cap)}};
  const mesh::RawMesh coarse = mesh::read_gmsh(half_ball(4)), fine = mesh::read_gmsh(half_ball(2));
  REQUIRE(coarse.dim == 3);
  const auto order = [](double exact_value, double a, double b) {
    CHECK(a < exact_value); // chords and inscribed polyhedra
    CHECK(b < exact_value);
    return std::log2((exact_value - a) / (exact_value - b));
  };
  const auto volume = [](const mesh::RawMesh& raw) { return total_measure(raw, raw.cells, 3); };
  // Unstructured meshes: the sizes are halved on average only.
  CHECK(std::abs(order(2 * pi / 3 * cube, volume(coarse), volume(fine)) - 2) < 0.4);
  REQUIRE(coarse.facets.size() == exact.size());
  for (const auto& [group, area] : exact)
    CHECK(std::abs(order(area, total_measure(coarse, coarse.facets.at(group), 2),
                         total_measure(fine, fine.facets.at(group), 2)) -
                   2) < 0.4);
}

TEST_CASE("surface groups hold their nodes once, on any number of ranks", "[mesh]") {
  const mesh::RawMesh raw = mesh::read_gmsh(half_ball(4));
  const mesh::Mesh mesh(MPI_COMM_WORLD, half_ball(4));
  CHECK(mesh.dim() == 3);
  CHECK(mesh.cells() == static_cast<std::int64_t>(raw.cells.size() / 4));
  for (const auto& [group, facets] : raw.facets)
    CHECK(test::total(static_cast<long>(mesh.facets(group, "test").size())) ==
          static_cast<long>(facets.size() / 3));
  for (int degree : {1, 2}) {
    CAPTURE(degree);
    const fem::Space space(mesh, degree);
    const double sag =
        degree == 1 ? 1e-12 : 0.6; // the middle of a chord of length 5 is this far inside the sphere, m
    for (const auto& [group, facets] : raw.facets) {
      const std::vector<int> nodes = space.nodes_on(group, "test");
      CHECK(test::total(static_cast<long>(nodes.size())) == nodes_of(facets, degree));
      for (int node : nodes) {
        const double* x = &space.points()[static_cast<std::size_t>(3 * node)];
        const double height = -radius * std::cos(cap);
        if (group == "top") {
          CHECK(std::abs(x[2]) < 1e-12);
          continue;
        }
        CHECK(std::abs(std::hypot(x[0], x[1], x[2]) - radius) < sag);
        CHECK((group == "contact" ? x[2] < height + 1e-9 : x[2] > height - 1e-9));
      }
    }
  }
  CHECK_THROWS_WITH(mesh.facets("botom", "clamp.on"), ContainsSubstring("surface group"));
  CHECK_THROWS_WITH(mesh.facets("body", "clamp.on"), ContainsSubstring("dimension 3"));
}

TEST_CASE("a .msh is read as a mesh alone, whatever it is called and whatever lies beside it", "[mesh]") {
  namespace fs = std::filesystem;
  const fs::path folder =
      fs::temp_directory_path() / fmt::format("signorini-msh-{}-{}", getpid(), rank(MPI_COMM_WORLD));
  fs::create_directory(folder);
  const fs::path trace = folder / "trace";
  const std::string command = fmt::format("SystemCall \"touch '{}'\";\n", trace.string());
  const std::string mesh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
                           "$PhysicalNames\n1\n2 1 \"body\"\n$EndPhysicalNames\n"
                           "$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n"
                           "$Elements\n1\n1 2 2 1 1 1 2 3\n$EndElements\n";
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    return folder / name;
  };
  const auto cells = [](const fs::path& file) {
    return mesh::read_gmsh({.file = file, .size = {}}).cells.size() / 3;
  };
  // A script is one in a .geo, and in the options that gmsh takes with a file of this name: the commands
  // work.
  (void)write("square.geo.opt", command);
  fs::copy_file(test::source("tests/data/square.geo"), folder / "square.geo");
  CHECK(mesh::read_gmsh({.file = folder / "square.geo", .size = 0.5}).dim == 2);
  REQUIRE(fs::remove(trace));
  (void)write("mesh.msh.opt", command);
  CHECK(cells(write("mesh.msh", mesh)) == 1);
  CHECK(cells(write("a b'$(touch trace).msh", mesh)) == 1);
  CHECK(cells(write("comments.msh", "$Comments\n" + command + "$EndComments\n" + mesh)) == 1);
  for (const std::string& text : {command + mesh, command + "$EndElements\n", "\n" + command + mesh,
                                  "$MeshFormats\n" + command + mesh, std::string()}) {
    CAPTURE(text);
    CHECK_THROWS_WITH(cells(write("hostile.msh", text)),
                      ContainsSubstring("hostile.msh: not a .msh file") &&
                          ContainsSubstring("first line must be $MeshFormat"));
  }
  CHECK_FALSE(fs::exists(trace));
  fs::remove_all(folder);
}

TEST_CASE("elements become small where the error comes from, and large elsewhere", "[mesh]") {
  const scene::Mesh square{.file = test::source("tests/data/square.geo"), .size = 0.05};
  constexpr double edge = 0.3; // of the part that has nearly all of the error
  const auto left_and_right = [](const mesh::Mesh& mesh) {
    std::array<long, 2> count{};
    const std::vector<double> middles = fem::Space(mesh, 1).midpoints();
    for (std::size_t i = 0; i < middles.size(); i += 3)
      ++count[middles[i] > edge];
    MPI_Allreduce(MPI_IN_PLACE, count.data(), 2, MPI_LONG, MPI_SUM, MPI_COMM_WORLD);
    return count;
  };
  const mesh::Mesh even(MPI_COMM_WORLD, square);
  const std::vector<double> middles = fem::Space(even, 1).midpoints();
  std::vector<double> indicators;
  for (std::size_t i = 0; i < middles.size(); i += 3)
    indicators.push_back(middles[i] > edge ? 1e-3 : 1);
  const mesh::SizeField sizes = mesh::sizes_by(even, indicators, 0.25, 4);
  CHECK((ranks(MPI_COMM_WORLD) == 1 || rank(MPI_COMM_WORLD) == 0 || sizes.sizes.empty()));
  const mesh::Mesh graded(MPI_COMM_WORLD, square, {.sizes = &sizes});
  const auto [left, right] = left_and_right(even);
  const auto [left_now, right_now] = left_and_right(graded);
  INFO(left << ", " << right << " cells, then " << left_now << ", " << right_now);
  CHECK(left_now > 3 * left); // half the size
  CHECK(left_now < 7 * left);
  CHECK(right_now < right);
  CHECK(graded.group_dimension("bottom", "contact.on") == 1); // groups stay
}

TEST_CASE("sizes at a curved boundary follow its curvature, and corners do not count", "[mesh]") {
  const auto sizes_of = [](const char* file, double size) {
    const mesh::Mesh mesh(MPI_COMM_WORLD, {.file = test::source(file), .size = size});
    std::vector<double> none(mesh.owned_cells().size()), all;
    mesh::SizeField field = mesh::gather_cells(mesh, none, all);
    field.sizes.assign(field.points.size() / 3, size);
    return field;
  };
  constexpr double around = 100, disc = 20; // elements; m
  mesh::SizeField curved = sizes_of("meshes/disc.geo", 4), flat = sizes_of("tests/data/square.geo", 0.25);
  mesh::limit_by_curvature(curved, around);
  long bent = 0;
  for (std::size_t node = 0; node < curved.sizes.size(); ++node) {
    const bool outside = std::hypot(curved.points[3 * node], curved.points[3 * node + 1]) > disc * (1 - 1e-9);
    bent += outside;
    // Between middles of neighbouring edges of the polygon the way is shorter than the arc, by a few per
    // cent.
    CHECK_THAT(curved.sizes[node],
               Catch::Matchers::WithinRel(outside ? 2 * std::numbers::pi * disc / around : 4, 0.03));
  }
  CHECK(bent > 20);
  mesh::limit_by_curvature(flat, around);
  CHECK(std::ranges::count(flat.sizes, 0.25) == std::ssize(flat.sizes));
  mesh::limit_growth(curved);
  const auto least = std::ranges::min(curved.sizes);
  constexpr double detour = 1.25; // of the way along edges to the boundary
  for (std::size_t node = 0; node < curved.sizes.size(); ++node)
    CHECK(curved.sizes[node] <
          1.05 * least +
              detour * (disc - std::hypot(curved.points[3 * node], curved.points[3 * node + 1])) / 3);
}

TEST_CASE("a .geo with sizes of its own makes the mesh that the sizes ask for", "[mesh]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // one rank reads
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / fmt::format("signorini-sizes-{}", getpid());
  fs::create_directories(folder);
  for (const char* name : {"tests/data/square.geo", "meshes/press.geo", "tests/data/parts-space.geo"}) {
    INFO(name);
    const scene::Mesh own{.file = test::source(name), .size = 0, .unit = scene::LengthUnit::mm};
    const mesh::RawMesh coarse = mesh::read_gmsh(own);
    mesh::SizeField sizes{.dim = coarse.dim, .points = coarse.points, .cells = coarse.cells};
    double extent = 0;
    for (const double x : coarse.points)
      extent = std::max(extent, std::abs(x));
    for (std::size_t i = 0; i < coarse.points.size(); i += 3)
      sizes.sizes.push_back(extent / 40 + std::hypot(coarse.points[i], coarse.points[i + 1]) / 10);
    scene::Mesh graded = own;
    graded.file = folder / "graded.geo";
    graded.size.reset();
    std::ofstream(graded.file) << mesh::geo_with_sizes(sizes, fs::relative(own.file, folder), 1e-3);
    const auto cells = [&](const mesh::RawMesh& mesh) {
      return static_cast<double>(mesh.cells.size()) / (mesh.dim + 1);
    };
    const mesh::RawMesh found = mesh::read_gmsh(graded);
    CHECK_THAT(cells(found),
               Catch::Matchers::WithinRel(cells(mesh::read_gmsh(own, {.sizes = &sizes})), 0.02));
    // No regular tetrahedra fill the space.
    CHECK_THAT(cells(found), Catch::Matchers::WithinRel(mesh::count_of(sizes), found.dim == 2 ? 0.35 : 0.65));
    CHECK(found.facets.size() == coarse.facets.size());
    graded.scale = 0.5;
    CHECK_THAT(cells(mesh::read_gmsh(graded)),
               Catch::Matchers::WithinRel(std::pow(2, found.dim) * cells(found), 0.25));
  }
  fs::remove_all(folder);
}

TEST_CASE("a mesh is refined where its edges are too long, and keeps its parts and groups", "[mesh]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // one rank does it
  namespace fs = std::filesystem;
  const fs::path file = fs::temp_directory_path() / fmt::format("signorini-refined-{}.msh", getpid());
  for (const char* name : {"tests/data/parts.geo", "tests/data/parts-space.geo"}) {
    INFO(name);
    const scene::Mesh scene{.file = test::source(name), .size = 5e-4, .unit = scene::LengthUnit::mm};
    const mesh::RawMesh coarse = mesh::read_gmsh(scene);
    // Lengths are thousandths: sizes that grow from a corner.
    mesh::SizeField sizes{.dim = coarse.dim, .points = coarse.points};
    for (std::size_t i = 0; i < coarse.points.size(); i += 3)
      sizes.sizes.push_back(5e-5 +
                            0.3 * std::hypot(coarse.points[i], coarse.points[i + 1], coarse.points[i + 2]));
    const mesh::RawMesh fine = mesh::refined(coarse, sizes);
    mesh::write_msh(fine, file, scene.unit);
    const mesh::RawMesh read = mesh::read_gmsh({.file = file, .unit = scene.unit}); // which looks for defects
    for (const mesh::RawMesh* now : {&fine, &read}) {
      CHECK(now->cells.size() > 2 * coarse.cells.size());
      CHECK(now->cells.size() == fine.cells.size());
      REQUIRE(now->parts.size() == coarse.parts.size());
      REQUIRE(now->facets.size() == coarse.facets.size());
      const auto part = [](const mesh::RawMesh& mesh, const std::string& group) {
        std::vector<std::int64_t> cells;
        const std::vector<std::int64_t>& ranges = mesh.parts.at(group);
        for (std::size_t r = 0; r < ranges.size(); r += 2)
          cells.insert(cells.end(), &mesh.cells[ranges[r] * (mesh.dim + 1)],
                       mesh.cells.data() + ranges[r + 1] * (mesh.dim + 1));
        return total_measure(mesh, cells, mesh.dim);
      };
      for (const auto& [group, ranges] : coarse.parts)
        CHECK_THAT(part(*now, group), Catch::Matchers::WithinRel(part(coarse, group), 1e-12));
      for (const auto& [group, facets] : coarse.facets)
        CHECK_THAT(total_measure(*now, now->facets.at(group), coarse.dim - 1),
                   Catch::Matchers::WithinRel(total_measure(coarse, facets, coarse.dim - 1), 1e-12));
    }
    double shortest = 1, longest = 0; // edges at the corner, and all
    for (std::size_t c = 0; c < fine.cells.size(); c += fine.dim + 1)
      for (int i = 0; i < fine.dim; ++i) {
        const double* a = &fine.points[3 * fine.cells[c + i]];
        const double* b = &fine.points[3 * fine.cells[c + i + 1]];
        const double edge = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
        shortest = std::min(shortest, edge);
        longest = std::max(longest, edge);
      }
    CHECK(shortest < std::sqrt(2) * 5e-5);
    CHECK(longest > 3e-4);
  }
  fs::remove(file);
}

TEST_CASE("a file that makes gmsh crash is refused by one sentence", "[mesh]") {
  if (ranks(MPI_COMM_WORLD) > 2)
    return; // one rank reads and tells the others, two as three
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(test::source("tests/fuzz/found")))
    if (entry.path().extension() == ".msh") {
      ++found;
      CHECK_THROWS_AS(mesh::read_gmsh({.file = entry.path(), .size = {}}), UserError);
    }
  CHECK(found > 0);
  CHECK(in_subprocess({"/bin/true"}, "a request") == ""); // which ends well, but answers nothing
  CHECK_THROWS_AS(in_subprocess({test::source("tests/no-such-program")}, "a request"), std::runtime_error);
  CHECK_THROWS_AS(find_program("no-such-program"), std::runtime_error);
}
