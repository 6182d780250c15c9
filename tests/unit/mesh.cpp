#include "base/error.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;

TEST_CASE("boundary groups hold their nodes once, on any number of ranks", "[mesh]") {
  const scene::Scene scene = test::parse(test::source("tests/data/manufactured.toml"));
  const mesh::Mesh mesh(MPI_COMM_WORLD, scene.mesh);
  CHECK(mesh.dim() == 2);
  CHECK(std::abs(mesh.diameter() - std::sqrt(2)) < 1e-14);
  for (int degree : {1, 2}) {
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
  CHECK_THROWS_WITH(mesh.facets("botom", "clamp.on"), ContainsSubstring("clamp.on") && ContainsSubstring("\"bottom\""));
  CHECK_THROWS_WITH(mesh.facets("body", "clamp.on"), ContainsSubstring("dimension 2"));
}
