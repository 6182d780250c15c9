// SPDX-License-Identifier: GPL-3.0-or-later
#include "fixtures.h"
#include "problem/parameter_problem.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <numeric>

using namespace signorini;

namespace {

double norm(std::span<const double> x) {
  return std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.0));
}

} // namespace

TEST_CASE("the adjoint gradient by parameters is that of linearised motions", "[adjoint]") {
  const std::string scheme = GENERATE("contact.mass=\"consistent\"", "time.scheme=\"contact-stabilized\"",
                                      "contact.mass=\"massless\"");
  const char* const file = GENERATE(as<const char*>{}, "tests/data/parameters.toml",
                                    "tests/data/surroundings.toml", "tests/data/relaxing.toml");
  CAPTURE(scheme, file);
  const scene::Scene scene = test::parse(test::source(file), {scheme});
  Timers timers;
  problem::ParameterProblem problem(test::discretised(scene), scene, timers);
  control::ReducedProblem& reduced = problem.reduced;
  const std::vector<double> x = problem.misfit.start();
  (void)reduced.value(control::Variables(x));
  reduced.accept();
  REQUIRE(std::ranges::any_of(reduced.trajectory().contact(), [](const contact::ContactLinearisation& step) {
    return !step.active.empty();
  }));
  const std::vector<double> adjoint = reduced.gradient_by_parameters();
  const optimize::LeastSquares linearised = reduced.least_squares(control::Variables(x));
  const std::vector<double> gradient = linearised.gradient();
  const std::size_t m = linearised.residuals.size();
  REQUIRE(adjoint.size() == scene.unknowns.size());
  for (std::size_t j = 0; j < adjoint.size(); ++j) {
    INFO("by " << scene.unknowns[j].name);
    const double size = norm(linearised.residuals) * norm({&linearised.jacobian[j * m], m});
    CHECK(std::abs(gradient[j]) > 1e-4 * size); // no gradient by chance orthogonal to the residuals
    CHECK(std::abs(adjoint[j] - gradient[j]) < 1e-9 * size);
  }
}
