#include "estimate.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>

using namespace signorini;
using petsc::check;

namespace {

/// J at the first guess of a scene and what is estimated to be its error.
struct Estimated {
  double J;
  adjoint::ErrorParts error;
};

Estimated estimated(const std::string& file, const std::vector<std::string>& overrides, bool contact) {
  const test::Ready ready(file, overrides);
  ControlProblem control_problem(ready.problem, test::silent());
  control_problem.reduced.value(control_problem.first_guess(ready.scene));
  control_problem.reduced.accept();
  bool touched = false;
  for (const contact::ContactSets& state : control_problem.reduced.trajectory().contact())
    touched |= !state.active.empty();
  REQUIRE(touched == contact);
  return {control_problem.reduced.value().total(), estimate_error(ready.problem, control_problem)};
}

std::vector<std::string> with(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// A block that a smooth force shears and a clamp holds: a linear problem on a domain that every mesh fills.
const std::vector<std::string> sheared{"contact.obstacle.point=[0, -9]", "initial.velocity=[\"0\", \"0\"]",
                                       "clamp=[{on=\"bottom\"}]", "contact.on=left", "load.body=[\"sin(2*t)\", \"y\"]",
                                       "control.initial=[\"0.5*y\", \"cos(t)\"]", "time.end=0.64"};

} // namespace

TEST_CASE("the error in time is estimated by its first term", "[adjoint]") {
  for (const std::vector<std::string>& scheme : {std::vector<std::string>{}, {"time.scheme=contact-stabilized"}}) {
    const std::vector<std::string> scene = with(sheared, scheme);
    const auto at = [&](const char* step) { return estimated("tests/data/block.toml", with(scene, {step}), false); };
    const double exact = at("time.step=0.0003125").J;
    std::vector<double> off;
    for (const char* step : {"time.step=0.02", "time.step=0.01"}) {
      const Estimated run = at(step);
      off.push_back(std::abs(run.error.time / (exact - run.J) - 1));
    }
    CHECK(off[0] < 0.1);
    CHECK(off[1] < off[0]);
  }
}

TEST_CASE("the error in space is estimated beside that of functions of degree 2", "[adjoint]") {
  const auto at = [&](const char* size, const char* degree) {
    return estimated("tests/data/block.toml", with(sheared, {size, degree}), false);
  };
  const double exact = at("mesh.size=0.05", "mesh.degree=2").J;
  std::vector<double> effectivity;
  for (const char* size : {"mesh.size=0.2", "mesh.size=0.1", "mesh.size=0.05"}) {
    const Estimated run = at(size, "mesh.degree=1");
    effectivity.push_back(*run.error.space / (exact - run.J));
    INFO("effectivity " << effectivity.back());
    CHECK((effectivity.back() > 0.5 && effectivity.back() < 2));
  }
  CHECK_FALSE(at("mesh.size=0.2", "mesh.degree=2").error.space);
}

TEST_CASE("errors in contact are estimated, those of the desired motion included", "[adjoint]") {
  for (const std::vector<std::string>& scheme :
       {std::vector<std::string>{}, {"time.scheme=contact-stabilized"}, {"contact.mass=massless"}}) {
    const auto at = [&](const char* size, const char* degree) {
      return estimated("scenes/half-disc.toml",
                       with({size, degree, "control.initial=[\"0\", \"-0.8\"]", "time.step=1e-4"}, scheme), true);
    };
    const double exact = at("mesh.size=0.5", "mesh.degree=2").J;
    const Estimated run = at("mesh.size=1", "mesh.degree=1");
    const double effectivity = *run.error.space / (exact - run.J);
    INFO("effectivity " << effectivity);
    CHECK((effectivity > 0.3 && effectivity < 3));
  }
}
