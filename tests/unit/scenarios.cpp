// SPDX-License-Identifier: GPL-3.0-or-later
#include "problem/scenarios.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

using namespace signorini;

namespace {

/// Changed keys of the scenarios, of which the first is the scene itself; the last has a D of its own.
const std::vector<std::vector<std::string>> changes{{},
                                                    {R"(initial.velocity=["0.1", "-1.3"])"},
                                                    {R"(contact.obstacle.point=[0, -0.15])"},
                                                    {R"(load.body=["0.2", "-0.8"])"},
                                                    {R"(material.young=80.0)"}};
const std::vector<double> weights{1, 2, 1, 0.5, 0.5}; // their sum is 5

std::vector<std::string> common(const char* scheme) {
  return {R"(objective.desired={displacement=["0", "-0.1*t"]})", std::string("time.scheme=") + scheme};
}

std::vector<std::string> with_scenarios(const char* scheme, double exponent) {
  std::string tables;
  for (std::size_t s = 0; s < changes.size(); ++s) {
    std::string set;
    for (std::string change : changes[s]) {
      const auto equals = change.find('=');
      set = fmt::format(", set = {{ \"{}\" = {} }}", change.substr(0, equals), change.substr(equals + 1));
    }
    tables += fmt::format("{{ weight = {}{} }}, ", weights[s], set);
  }
  std::vector<std::string> all = common(scheme);
  all.push_back("scenario=[" + tables + "]");
  if (exponent != 1)
    all.push_back(fmt::format("objective.exponent={}", exponent));
  return all;
}

double relative(const control::ControlSpace& controls, control::Control a, const control::Control& b) {
  a.add(-1, b);
  return controls.norm(a) / controls.norm(b);
}

} // namespace

TEST_CASE("J of scenarios and its derivatives are those of separate problems", "[control]") {
  const char* scheme = GENERATE(as<const char*>{}, "contact-implicit", "contact-stabilized");
  const double p = GENERATE(1.0, 6.0);
  CAPTURE(scheme, p);
  const test::Ready ready("tests/data/block.toml", with_scenarios(scheme, p));
  problem::ControlProblem all(ready.problem, test::silent());
  const control::Control u = all.controls.interpolate({"0.2", "-0.6"}, "test"),
                         d = all.controls.interpolate({"0.1*x", "0.3 - t"}, "test");
  const double value = all.reduced.value(u);
  all.reduced.accept();
  const control::Control g = all.reduced.l2_gradient();
  control::Control at_once = all.reduced.gradient().u;
  CHECK(relative(all.controls, all.controls.dual(at_once), all.controls.dual([&] {
          control::Control same = g;
          all.controls.to_inner(same);
          return same;
        }())) < 1e-13);

  double sum = 0;
  std::vector<double> J;
  std::vector<control::Control> gradients, products;
  for (std::size_t s = 0; s < changes.size(); ++s) {
    std::vector<std::string> overrides = common(scheme);
    overrides.insert(overrides.end(), changes[s].begin(), changes[s].end());
    const test::Ready alone("tests/data/block.toml", overrides);
    problem::ControlProblem one(alone.problem, test::silent());
    J.push_back(one.reduced.value(u));
    one.reduced.accept();
    std::size_t closed = 0;
    for (const contact::ContactLinearisation& step : one.reduced.contact())
      closed += step.active.size();
    REQUIRE(closed > 3);
    gradients.push_back(one.reduced.l2_gradient());
    products.push_back(one.reduced.l2_hessian_product(d));
    sum += weights[s] / 5 * std::pow(J.back(), p);
  }
  const double mean = std::pow(sum, 1 / p);
  REQUIRE(std::abs(J[0] / J[1] - 1) > 0.1); // the scenarios differ
  CHECK(std::abs(value / mean - 1) < 1e-9);

  control::Control gradient = all.controls.zero(), product = all.controls.zero();
  double slope = 0;
  for (std::size_t s = 0; s < J.size(); ++s) {
    const double share = weights[s] / 5 * std::pow(J[s] / mean, p - 1);
    gradient.add(share, gradients[s]);
    product.add(share, products[s]);
    slope += share * all.controls.product(gradients[s], d);
    product.add(weights[s] / 5 * (p - 1) / mean * std::pow(J[s] / mean, p - 2) *
                    all.controls.product(gradients[s], d),
                gradients[s]);
  }
  product.add(-(p - 1) / mean * slope, gradient);
  // Contact-implicit steps amplify the rounding by which block and single steps differ.
  CHECK(relative(all.controls, g, gradient) < 1e-8);
  CHECK(relative(all.controls, all.reduced.l2_hessian_product(d), product) < 1e-7);
  const control::ReducedProblem::OneSided one_sided = all.reduced.one_sided_slope(d);
  CHECK(one_sided.by_motion.defect(slope) < 1e-8);
  CHECK(one_sided.by_motion.defect(one_sided.by_gradient) < 1e-10);
}

TEST_CASE("scenarios of weight zero change neither J nor the cost of its gradient", "[control]") {
  const std::vector<std::string> without = common("contact-stabilized");
  std::vector<std::string> with = without;
  with.push_back(R"(scenario=[{}, { weight = 0, set = { "initial.velocity" = ["0", "-2"] } }])");
  const test::Ready ready("tests/data/block.toml", with), plain("tests/data/block.toml", without);
  problem::ControlProblem two(ready.problem, test::silent()), one(plain.problem, test::silent());
  CHECK(two.reduced.value(two.controls.zero()) == one.reduced.value(one.controls.zero()));
  const control::Control g = two.reduced.trial_gradient().u, same = one.reduced.trial_gradient().u;
  CHECK(relative(two.controls, g, same) < 1e-14);
  CHECK((two.reduced.sweeps().forward == 2 && two.reduced.sweeps().adjoint == 1));
}
