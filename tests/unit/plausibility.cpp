// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/plausibility.h"
#include "base/collective.h"
#include "fem/coherence.h"
#include "fem/deformation.h"
#include "fixtures.h"
#include "io/point_match.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <fmt/format.h>
#include <set>

using namespace signorini;
using petsc::check;

namespace {

std::string mesh_of(const std::string& name) {
  return "mesh.file=" + test::source("tests/data/" + name).string();
}

struct Body {
  scene::Scene scene;
  mesh::Mesh mesh;
  fem::Space space;

  explicit Body(const std::vector<std::string>& overrides, const std::string& file = "tests/data/block.toml",
                MPI_Comm comm = MPI_COMM_WORLD)
      : scene(test::parse(test::source(file), overrides)), mesh(comm, scene.mesh),
        space(mesh, scene.mesh.degree) {}

  [[nodiscard]] fem::Deformation deformation(const scene::Components& y) const {
    petsc::Vector x = space.vector();
    space.interpolate(scene::Field(y, "test", false), 0, x);
    return fem::deformation(space, x);
  }
};

/// The kinds of warnings that a run of the block ends with.
std::set<std::string> warnings(std::vector<std::string> overrides) {
  const test::Ready ready("tests/data/block.toml", overrides);
  const problem::Problem& problem = ready.problem;
  diagnostics::Balance weigh(problem.stepper);
  diagnostics::Plausibility watch(problem.stepper, ready.scene);
  const step::ForceAtStep load = problem.load();
  trajectory::integrate(problem.stepper, problem.grid, problem.initial, load,
                        [&](const trajectory::Frame& frame) {
                          const diagnostics::StepBalance balance = weigh(frame);
                          watch.observe(frame, &balance);
                        });
  std::set<std::string> names;
  for (const Warning& warning : watch.warnings()) {
    CHECK(warning.value > warning.limit);
    CHECK_FALSE(warning.message.empty());
    names.insert(warning.name);
  }
  return names;
}

/// Softly put down on the plane below: nothing to tell.
const std::vector<std::string> gentle{"initial.velocity=[\"0\", \"-0.01\"]", "load.body=[\"0\", \"-0.1\"]",
                                      "contact.obstacle.normal=[0, 1]", "contact.obstacle.point=[0, -1e-3]"};

std::vector<std::string> gentle_but(const std::vector<std::string>& overrides) {
  std::vector<std::string> all = gentle;
  all.insert(all.end(), overrides.begin(), overrides.end());
  return all;
}

using Names = std::set<std::string>;

} // namespace

TEST_CASE("strain, rotation and turned elements of known motions", "[fem]") {
  for (const char* degree : {"mesh.degree=1", "mesh.degree=2"}) {
    CAPTURE(degree);
    const Body plane({degree});
    // ε = [[0.02, 0.03], [0.03, −0.06]] and a rotation by 0.01: principal strains −0.02 ± 0.05.
    const fem::Deformation both = plane.deformation({"0.02*x + 0.02*y", "0.04*x - 0.06*y"});
    CHECK(std::abs(both.strain.value - 0.07) < 1e-14);
    CHECK(std::abs(both.rotation.value - 0.01) < 1e-14);
    CHECK(both.inverted == 0);
    CHECK(plane.deformation({"1", "-2"}).strain.value < 1e-13);
    CHECK(plane.deformation({"-1.1*x", "0"}).inverted == plane.mesh.cells());
    CHECK(plane.deformation({"-0.9*x", "0"}).inverted == 0);
    const Body space({degree}, "tests/data/cube.toml");
    // A turn about (1, 2, 2)/3 by 0.03.
    const fem::Deformation turned =
        space.deformation({"-0.02*y + 0.02*z", "0.02*x - 0.01*z", "-0.02*x + 0.01*y"});
    CHECK(turned.strain.value < 1e-14);
    CHECK(std::abs(turned.rotation.value - 0.03) < 1e-14);
    const fem::Deformation stretched = space.deformation({"0.01*x + 0.02*y", "0.02*x + 0.01*y", "-0.02*z"});
    CHECK(std::abs(stretched.strain.value - 0.03) < 1e-14);
    CHECK(stretched.rotation.value < 1e-15);
  }
  const Body bent({"mesh.degree=2"});
  const fem::Deformation quadratic = bent.deformation({"x^2", "0"});
  CHECK(std::abs(quadratic.strain.value - 2) < 1e-12); // at x = 1
  CHECK(std::abs(quadratic.strain.at[0] - 1) < 1e-12);
}

TEST_CASE("the place of the largest strain is that of the least coordinates, on any number of ranks",
          "[fem]") {
  struct Case {
    const char* file;
    scene::Components y; ///< of which the largest strain and rotation are attained at many places
  };
  for (const Case& c : {Case{"tests/data/block.toml", {"0.02*x - 0.01*y", "0.04*x"}},
                        Case{"tests/data/block.toml", {"0.1*(x - 0.5)^2", "0.1*(x - 0.5)^2"}},
                        Case{"tests/data/cube.toml", {"0.01*x - 0.03*y", "0.03*x", "0.02*z"}},
                        Case{"tests/data/cube.toml", {"0", "0.1*(z - 0.5)^2", "0"}}})
    for (const char* degree : {"mesh.degree=1", "mesh.degree=2"}) {
      INFO(c.file << " " << degree << " " << c.y.front().text);
      const fem::Deformation shared = Body({degree}, c.file).deformation(c.y),
                             alone = Body({degree}, c.file, MPI_COMM_SELF).deformation(c.y);
      REQUIRE(shared.strain.value > 0.01);
      REQUIRE(shared.rotation.value > 0.01);
      CHECK(std::abs(shared.strain.value / alone.strain.value - 1) < 1e-12);
      CHECK(std::abs(shared.rotation.value / alone.rotation.value - 1) < 1e-12);
      CHECK(shared.strain.at == alone.strain.at);
      CHECK(shared.rotation.at == alone.rotation.at);
      if (std::string(degree) == "mesh.degree=2") // at a vertex; all of these strains are largest at this one
        CHECK(shared.strain.at == std::array<double, 3>{});
    }
}

TEST_CASE("parts of a mesh that do not hang together are counted on any number of ranks", "[fem]") {
  for (const char* degree : {"mesh.degree=1", "mesh.degree=2"})
    for (const char* size : {"mesh.size=0.5", "mesh.size=0.07"}) {
      CAPTURE(degree, size);
      CHECK(fem::connected_parts(Body({degree, size}).space).count == 1);
      CHECK(fem::connected_parts(Body({degree, size, mesh_of("cracked.geo")}).space).count == 1);
      CHECK(fem::connected_parts(Body({degree, size, mesh_of("apart.geo")}).space).count == 2);
    }
}

TEST_CASE("facets inside the body and facets of held nodes are counted once", "[fem]") {
  const Body body({mesh_of("parts.geo"), "mesh.size=0.25"});
  CHECK(fem::inner_facets(body.mesh, "interface", "test") == 4);
  CHECK(fem::inner_facets(body.mesh, "boundary", "test") == 0);
  std::vector<PetscInt> nodes;
  for (int node : body.space.nodes_on("bottom", "test"))
    nodes.push_back(body.space.first_dof() + node * 2);
  nodes = gather(MPI_COMM_WORLD, nodes);
  std::ranges::sort(nodes);
  CHECK(fem::facets_among(body.space, "bottom", "test", nodes) == 8);
  CHECK(fem::facets_among(body.space, "start", "test", nodes) == 0); // one node alone
  CHECK(fem::facets_among(body.space, "boundary", "test", nodes) == 8);
}

TEST_CASE("a run is told what makes it mean less than it seems to, and nothing else", "[forward]") {
  CHECK(warnings(gentle) == Names{});
  CHECK(warnings(gentle_but({"mesh.degree=2"})) == Names{});
  CHECK(warnings(gentle_but({"initial.velocity=[\"0\", \"-2\"]"})).contains("large strain"));
  CHECK(warnings(gentle_but({"contact.obstacle.point=[0, -9]", "initial.velocity=[\"-0.5*y\", \"0.5*x\"]",
                             "load.body=[\"0\", \"0\"]"}))
            .contains("large rotation"));
  CHECK(warnings(gentle_but({"contact.obstacle.point=[0, -9]", "initial.displacement=[\"-1.5*x\", \"0\"]"}))
            .contains("elements turned inside out"));
  CHECK(warnings(gentle_but({mesh_of("apart.geo")})) == Names{"parts of the mesh"});
  CHECK(warnings(gentle_but({mesh_of("cracked.geo")})) == Names{});
  CHECK(
      warnings(gentle_but(
          {mesh_of("parts.geo"),
           "contact=[{on=\"interface\", obstacle={shape=\"half-space\", point=[0, -9], normal=[0, 1]}}]"})) ==
      Names{"contact inside the body"});
  // Half of the boundary is held; the ends of a clamp, which belong to both, are not told.
  CHECK(warnings(gentle_but({"clamp=[{on=\"rest\"}]", "contact.on=\"boundary\"",
                             "initial.velocity=[\"0\", \"0\"]"})) == Names{"contact on a clamp"});
  CHECK(warnings(gentle_but({"clamp=[{on=\"rest\"}]", "initial.velocity=[\"0\", \"0\"]"})) == Names{});
}

TEST_CASE("motion along a curved obstacle is told where its half-space is no longer good", "[forward]") {
  const auto ball = [](double radius, const char* velocity) {
    return gentle_but({fmt::format("contact.obstacle={{shape=\"ball\", center=[0.5, {}], radius={}}}",
                                   -radius - 1e-3, radius),
                       fmt::format("initial.velocity=[\"{}\", \"-0.01\"]", velocity)});
  };
  CHECK(warnings(ball(10, "0")) == Names{});
  CHECK(warnings(ball(10, "0.5")) == Names{}); // by 0.3 m
  // The flat face is bent by half-spaces that fan out, and so strained too.
  const Names sharp = warnings(ball(0.1, "0.5"));
  CHECK(sharp.contains("motion beyond an obstacle's radius"));
  CHECK(sharp.contains("linearised gap"));
  // The same surface as an expression has no radius.
  const auto level = gentle_but(
      {"contact.obstacle={shape=\"signed-distance\", distance=\"sqrt((x - 0.5)^2 + (y + 0.101)^2) - 0.1\"}",
       "initial.velocity=[\"0.5\", \"-0.01\"]"});
  const Names told = warnings(level);
  CHECK(told.contains("linearised gap"));
  CHECK_FALSE(told.contains("motion beyond an obstacle's radius"));
}

TEST_CASE("nodes at one place are told apart by their cells", "[mesh]") {
  const Body cracked({mesh_of("cracked.geo"), "mesh.size=0.2"});
  const std::vector<double>& points = cracked.space.points();
  std::vector<double> apart = io::distinct_points(cracked.space), there;
  long moved = 0;
  for (std::size_t i = 0; i < points.size(); i += 3)
    if (points[i] != apart[i] || points[i + 1] != apart[i + 1]) {
      ++moved;
      CHECK(std::abs(points[i] - 1) < 1e-12);
      CHECK(points[i + 1] > 0.5);
    }
  CHECK(test::total(moved) >= 4);
  CHECK(test::total(moved) % 2 == 0);
  // Each finds itself among all, in another order.
  const std::vector<double> all = gather(MPI_COMM_WORLD, apart);
  for (std::size_t i = all.size(); i >= 3; i -= 3)
    there.insert(there.end(), {all[i - 3], all[i - 2]});
  const auto fail = [](const std::string& problem) { throw UserError(problem); };
  const std::vector<std::size_t> rows = io::match_points(cracked.space, there, apart, fail);
  for (std::size_t i = 0; i < rows.size(); ++i)
    CHECK(std::abs(there[2 * rows[i]] - apart[3 * i]) + std::abs(there[2 * rows[i] + 1] - apart[3 * i + 1]) <
          1e-12);
  // Without, they are refused.
  there.clear();
  const std::vector<double> places = gather(MPI_COMM_WORLD, points);
  for (std::size_t i = 0; i < places.size(); i += 3)
    there.insert(there.end(), {places[i], places[i + 1]});
  CHECK_THROWS_AS(io::match_points(cracked.space, there, points, fail), UserError);
  const Body whole({"mesh.size=0.2"});
  CHECK(io::distinct_points(whole.space) == whole.space.points());
}
