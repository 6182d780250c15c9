// SPDX-License-Identifier: GPL-3.0-or-later
// Motions that start in equilibrium (initial.static).
#include "base/error.h"
#include "body.h"
#include "step/functionals.h"
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>

using namespace signorini;
using Catch::Approx;

namespace {

const std::vector<std::string> resting{"initial={static=true}", "contact.obstacle.normal=[0, 1]",
                                       "contact.obstacle.point=[0, 0]", "load={gravity=[\"0\", \"-1\"]}"};

std::vector<std::string> with(std::vector<std::string> all, const std::vector<std::string>& more) {
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

} // namespace

TEST_CASE("a body in equilibrium stays at rest", "[forward]") {
  const std::vector<std::string> more = GENERATE(
      std::vector<std::string>{}, std::vector<std::string>{"time.scheme=contact-stabilized"},
      std::vector<std::string>{"contact.mass=massless"}, std::vector<std::string>{"mesh.degree=2"},
      std::vector<std::string>{"contact.friction=0.3"},
      std::vector<std::string>{"contact.friction={bound=0.1}"},
      std::vector<std::string>{"contact.friction=0.3", "contact.mass=massless-tangential",
                               "time.scheme=contact-stabilized"},
      std::vector<std::string>{"solver.linear=iterative"},
      // hangs on a clamp that moves with the load of t = 0, which grows later
      std::vector<std::string>{"contact.obstacle.point=[0, -9]", "clamp=[{on=\"top\"}]"},
      std::vector<std::string>{"material.prony=[{g=0.3, k=0.3, time=0.1}]", "material.moduli=long-term"});
  CAPTURE(more);
  const test::Ready ready("tests/data/block.toml", with(resting, more));
  const test::Recorded motion(ready.problem, ready.problem.load());
  const double sunk = test::largest(motion.y.front());
  CHECK(sunk > 1e-3); // of the order of the weight over Young's modulus
  REQUIRE(motion.steps == 30);
  const bool iterative = std::ranges::find(more, "solver.linear=iterative") != more.end();
  for (std::size_t k = 1; k < motion.y.size(); ++k)
    CHECK(test::difference(motion.y[k], motion.y.front()) < (iterative ? 1e-6 : 2e-9) * sunk);
}

TEST_CASE("where nothing holds a body in equilibrium, it starts to slide without vibrations", "[forward]") {
  const test::Ready ready("tests/data/block.toml", with(resting, {"load={gravity=[\"0.5\", \"-1\"]}"}));
  const test::Recorded motion(ready.problem, ready.problem.load());
  REQUIRE(motion.steps == 30);
  const double tau = ready.scene.time.step;
  for (std::size_t k = 1; k < motion.y.size(); ++k) {
    petsc::Vector moved = petsc::copy(motion.y[k]);
    petsc::check(VecAXPY(moved, -1, motion.y.front()));
    const double t = static_cast<double>(k) * tau;
    petsc::check(VecAXPY(moved, -0.25 * t * t, step::translation(ready.problem.space, 0)));
    CHECK(test::largest(moved) < 1e-8);
    CHECK(motion.contact[k].count(contact::Status::strong) == 5);
  }
}

TEST_CASE("a body without equilibrium is refused", "[forward]") {
  // It tips over.
  CHECK_THROWS_AS(test::Ready("tests/data/block.toml",
                              with(resting, {"load={traction=[{on=\"top\", value=[\"1\", \"0\"]}]}"})),
                  UserError);
}
