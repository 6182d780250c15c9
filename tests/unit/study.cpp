// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/analysis.h"
#include "accuracy/grading.h"
#include "accuracy/measure.h"
#include "accuracy/quantities.h"
#include "base/collective.h"
#include "base/error.h"
#include "fem/sampler.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <limits>
#include <utility>

using namespace signorini;
using namespace signorini::accuracy;
using Catch::Matchers::WithinAbs, Catch::Matchers::WithinRel;

namespace {

const Quantity Q{"Q", "Q", "", false, false};
/// Of differences that are not divided by values which change with the rung, so that models of errors come
/// out exactly.
const Quantity D{"Q", "Q", "", false, true};
const Quantity F{"F", "F", "", true, false};
constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

RungResult run(double size, int steps, double seconds, double value) {
  Measured measured;
  measured.unknowns = std::lround(1000 / (size * size)); // another mesh for another size
  measured.steps = steps;
  measured.seconds = seconds;
  measured.numbers["Q"] = value;
  measured.fields["F"] = {value, -value};
  return {{size, steps, 1, scene::ContactScheme::contact_implicit}, measured};
}

/// Runs of four sizes h and numbers N of steps with the number Q = 1 + a h^p + b N^-q.
std::vector<RungResult> runs(double a, double p, double b, double q) {
  std::vector<RungResult> results;
  for (double size : {4.0, 2.0, 1.0, 0.5})
    for (int steps : {10, 20, 40, 80})
      results.push_back(
          run(size, steps, steps / (size * size), 1 + a * std::pow(size, p) + b * std::pow(steps, -q)));
  return results;
}

/// Runs of one size and ever more steps, by their seconds and values.
std::vector<RungResult> chain(const std::vector<std::pair<double, double>>& of) {
  std::vector<RungResult> results;
  for (int steps = 10; const auto& [seconds, value] : of)
    results.push_back(run(1, std::exchange(steps, 2 * steps), seconds, value));
  return results;
}

} // namespace

TEST_CASE("samples are the same on any number of ranks, and those of functions of V exact", "[study]") {
  for (const char* file : {"tests/data/block.toml", "tests/data/cube.toml"})
    for (const char* degree : {"mesh.degree=1", "mesh.degree=2"}) {
      CAPTURE(file, degree);
      const test::Ready ready(file, {degree});
      const fem::Quadrature quadrature = fem::quadrature(ready.problem.mesh);
      const auto dim = static_cast<std::size_t>(ready.problem.space.dim());
      double volume = 0, second = 0;
      for (std::size_t i = 0; i < quadrature.weights.size(); ++i) {
        volume += quadrature.weights[i];
        second += quadrature.weights[i] * quadrature.points[3 * i] * quadrature.points[3 * i + 1];
      }
      CHECK_THAT(volume, WithinRel(1.0, 1e-12)); // of the unit square and cube
      CHECK_THAT(second, WithinRel(0.25, 1e-12));
      std::vector<double> points = quadrature.points;
      const std::array outside{-0.05, 0.5, dim == 2 ? 0.0 : 0.4};
      points.insert(points.end(), outside.begin(), outside.end());
      const auto line = [](const double* x, std::size_t c) {
        return 1 + x[0] - 2 * x[1] + 3 * x[2] + static_cast<double>(c);
      };
      const petsc::Vector y = ready.problem.space.vector();
      {
        const petsc::WriteArray values(y);
        for (std::size_t i = 0; i < values.size(); ++i)
          values[i] = line(&ready.problem.space.points()[i / dim * 3], i % dim);
      }
      const std::vector<double> sampled = fem::Sampler(ready.problem.space, points)(y);
      double off = 0;
      for (std::size_t i = 0; i < sampled.size(); ++i)
        off = std::max(off, std::abs(sampled[i] - line(&points[i / dim * 3], i % dim)));
      CHECK(off < 1e-12);
    }
}

TEST_CASE("orders in space, in time and in both are those of the model, to rounding", "[study]") {
  constexpr double rounding = 1e-9; // differences of numbers near one, the least of them 1e-5 of that
  const std::vector<Orders> apart = orders(D, runs(0.1, 1.5, 3, 0.5), {});
  REQUIRE(apart.size() == 1);
  CHECK_THAT(apart[0].space->slope, WithinAbs(1.5, rounding));
  CHECK_THAT(apart[0].time->slope, WithinAbs(0.5, rounding));
  CHECK_THAT(apart[0].time->least, WithinAbs(0.5, rounding));
  CHECK_THAT(apart[0].time->largest, WithinAbs(0.5, rounding));
  const std::vector<Orders> together = orders(D, runs(0.1, 2, 3, 2), {});
  CHECK_THAT(together[0].both->slope, WithinAbs(2, rounding)); // size halves as steps double
  CHECK_THAT(orders(D, runs(0.1, 2, 3, 2), {{{"Q", 1}}, {}})[0].both->slope, WithinAbs(2, rounding));
  // Degrees and schemes are told apart.
  std::vector<RungResult> two = runs(0.1, 2, 3, 1);
  for (RungResult& result : runs(0.01, 3, 3, 1)) {
    result.rung.degree = 2;
    two.push_back(result);
  }
  const std::vector<Orders> by_degree = orders(D, two, {});
  REQUIRE(by_degree.size() == 2);
  for (const Orders& one : by_degree)
    CHECK_THAT(one.space->slope, WithinAbs(one.degree + 1, 1e-8));
}

TEST_CASE("errors are relative to what is known, or to the finest rung", "[study]") {
  const std::vector<RungResult> results = chain({{1, 3}, {2, 1.5}, {3, 2}});
  const Errors against_exact = errors(Q, results, {{{"Q", -2}}, {}});
  CHECK_FALSE(against_exact.reference);
  CHECK(against_exact.error == std::vector<std::optional<double>>{2.5, 1.75, 2.0});
  const Errors against_finest = errors(Q, results, {});
  CHECK(against_finest.reference == std::size_t(2));
  CHECK(against_finest.error == std::vector<std::optional<double>>{0.5, 0.25, std::nullopt});
  CHECK(errors(D, results, {}).error == std::vector<std::optional<double>>{1.0, 0.5, std::nullopt});
  const Errors field = errors(F, results, {{}, {{"F", {3, 4}}}});
  CHECK_THAT(*field.error[0], WithinRel(7.0 / 5, 1e-14)); // (3, −3) beside (3, 4), whose length is 5
  // The finest is the smallest size, and of those the one with the most steps, wherever it stands.
  std::vector<RungResult> mixed{run(0.5, 10, 1, 1), run(0.5, 40, 1, 4), run(1, 80, 1, 8)};
  CHECK(errors(Q, mixed, {}).reference == std::size_t(1));
}

TEST_CASE("the estimate is exact where errors fall as the model says, and has no effectivity beside a "
          "reference as bad",
          "[study]") {
  constexpr double rounding = 1e-8;
  const Errors found = errors(D, runs(0.1, 2, 3, 1), {{{"Q", 1}}, {}});
  int estimated = 0;
  for (const std::optional<double>& effectivity : found.effectivity)
    if (effectivity) {
      ++estimated;
      CHECK_THAT(*effectivity, WithinAbs(1, rounding));
    }
  CHECK(estimated == 9); // those with a wider and a longer neighbour
  // Beside the finest rung errors lack its own, r, which is shown where it is a third of theirs at most: (e +
  // r) / e in [1, 4/3].
  const Errors beside_finest = errors(D, runs(0.1, 2, 3, 1), {});
  REQUIRE(beside_finest.effectivity[5]); // size 2, 20 steps: e + r = 0.4 + 0.15, r = 0.025 + 0.0375
  CHECK_THAT(*beside_finest.effectivity[5], WithinAbs(0.55 / (0.55 - 0.0625), rounding));
  CHECK_FALSE(beside_finest.effectivity[14]); // size 0.5, 40 steps: e + r = 0.025 + 0.075
  for (const std::optional<double>& effectivity : beside_finest.effectivity)
    if (effectivity)
      CHECK((*effectivity >= 1 && *effectivity <= 4.0 / 3 + rounding));
}

TEST_CASE("on the front is what no cheaper rung is as accurate as", "[study]") {
  // By seconds and moduli, from long steps to short ones: the cheapest; better by luck, as the next shows;
  // dearer and as good; two alike; as dear as they; the best.
  const std::vector<RungResult> results =
      chain({{1, 0.6}, {2, 0.2}, {3, -0.6}, {4, 0.4}, {4, 0.4}, {4, 0.4}, {9, 0.1}});
  const Errors found = errors(D, results, {{{"Q", 0}}, {}});
  CHECK(found.envelope == std::vector<std::optional<double>>{0.6, 0.6, 0.6, 0.4, 0.4, 0.4, 0.1});
  CHECK(found.pareto == std::vector<bool>{true, false, false, true, true, true, true});
}

TEST_CASE("an envelope counts the rungs of its method that are as fine in size and in step", "[study]") {
  std::vector<RungResult> results{run(2, 10, 1, 1.3), run(2, 20, 2, 1.01), run(1, 10, 3, 1.1),
                                  run(1, 20, 4, 1.05), run(0.5, 10, 5, 1.2)};
  const Exact exact{{{"Q", 1}}, {}};
  const std::vector<double> expected{0.3, 0.05, 0.2, 0.05, 0.2};
  for (std::size_t i = 0; i < results.size(); ++i)
    CHECK_THAT(*errors(Q, results, exact).envelope[i], WithinAbs(expected[i], 1e-12));
  // What another degree does says nothing of this one.
  results.push_back(run(0.25, 40, 6, 2));
  results.back().rung.degree = 2;
  CHECK_THAT(*errors(Q, results, exact).envelope[3], WithinAbs(0.05, 1e-12));
  // Where a finer rung has no number nothing is known, and where it has not run it does not count.
  results[4].measured->numbers["Q"] = no_number;
  const Errors spoilt = errors(Q, results, exact);
  CHECK_FALSE(spoilt.envelope[0]);
  CHECK_FALSE(spoilt.envelope[2]);
  CHECK(spoilt.envelope[3]);
  results[4].measured.reset();
  CHECK_THAT(*errors(Q, results, exact).envelope[2], WithinAbs(0.1, 1e-12));
}

TEST_CASE("the finest rung's error bar is that of its row and its column, and of J what the adjoint says",
          "[study]") {
  // 1 + 0.1 h^2 + 3 / N at h = 0.5 and N = 80, twice.
  constexpr double in_size = 0.1 * 0.25, in_step = 3.0 / 80;
  const Errors found = errors(D, runs(0.1, 2, 3, 1), {});
  REQUIRE(found.bar);
  CHECK_THAT(*found.bar->size, WithinRel(2 * in_size, 1e-6));
  CHECK_THAT(*found.bar->step, WithinRel(2 * in_step, 1e-6));
  CHECK_THAT(found.bar->value, WithinRel(2 * (in_size + in_step), 1e-6));
  CHECK(found.bar->asymptotic);
  CHECK_FALSE(errors(D, runs(0.1, 2, 3, 1), {{{"Q", 1}}, {}}).bar); // an exact value has none
  // Meshes that are the same whatever their size tell nothing of it.
  std::vector<RungResult> same = runs(0, 2, 3, 1);
  for (RungResult& result : same)
    result.measured->unknowns = 12;
  CHECK_FALSE(errors(D, same, {}).bar->size);
  CHECK(errors(D, same, {}).bar->step);
  CHECK(words(*errors(D, same, {}).bar) == "error bar 7.5 % from the step only, error of the size unknown");
  // J of one rung beside another of half the size: parts of opposite sign do not make up for each other.
  const Quantity J{"J", "J", ""};
  std::vector<RungResult> two{run(2, 10, 1, 0), run(1, 10, 2, 0)};
  two[0].measured->numbers["J"] = 1.01, two[1].measured->numbers["J"] = 1;
  two[1].measured->estimate = {0.3, -0.2, 0, 0};
  CHECK_THAT(errors(J, two, {}).bar->value, WithinRel(0.5, 1e-12));
  two[1].measured->estimate = {0.3, 0.2, 0, 0};
  CHECK_THAT(errors(J, two, {}).bar->value, WithinRel(1.0, 1e-12));
  two[1].measured->estimate = {1e-3, 0, 0, 0};
  CHECK_THAT(errors(J, two, {}).bar->value, WithinRel(0.03, 1e-9)); // three times the difference
}

TEST_CASE("the cheapest rung for each tolerance is named, and what is out of reach", "[study]") {
  const scene::Scene scene = test::parse(test::source("scenes/half-disc.toml"));
  const std::vector<RungResult> results = chain({{1, 1.0005}, {2, 1.09}, {4, 1.008}, {8, 1.005}});
  const std::vector<std::string> said = sentences(errors(Q, results, {{{"Q", 1}}, {}}), results, scene);
  REQUIRE(said.size() == 4);
  // The first rung is as near as the last by luck: 9 % off with half the step.
  const std::string there = "at this rung and all finer ones)";
  CHECK(said[0] ==
        "for an error of 10 % in Q: " + words(results[0].rung, scene) + ", 1 s (error at most 9 % " + there);
  CHECK(said[1] ==
        "for an error of 5 % in Q: " + words(results[2].rung, scene) + ", 4 s (error at most 0.8 % " + there);
  CHECK(said[2] ==
        "for an error of 1 % in Q: " + words(results[2].rung, scene) + ", 4 s (error at most 0.8 % " + there);
  CHECK(said[3] == "an error of 0.1 % in Q is not reached by any rung of this study; the smallest is 0.5 %");
}

TEST_CASE("nothing is promised that the finest rung itself may be off by", "[study]") {
  const scene::Scene scene = test::parse(test::source("scenes/half-disc.toml"));
  // 1 + 8.8 / N from 10 to 80 steps: the finest is off by 11 %, and its neighbour differs from it by no more.
  const std::vector<RungResult> results = chain({{1, 1.88}, {2, 1.44}, {4, 1.22}, {8, 1.11}});
  const Errors found = errors(D, results, {});
  CHECK_THAT(found.bar->value, WithinRel(2 * 0.11, 1e-9));
  const std::vector<std::string> said = sentences(found, results, scene);
  REQUIRE(said.size() == 1);
  CHECK(said[0] ==
        "an error of 10 % in Q is not reached by any rung of this study; the smallest is 33 % (finest rung: "
        "error bar 22 % from the step only, error of the size unknown)");
  // Ten times as near it is promised, with the bar beside it.
  const std::vector<RungResult> nearer = chain({{1, 1.088}, {2, 1.044}, {4, 1.022}, {8, 1.011}});
  const std::string first = sentences(errors(D, nearer, {}), nearer, scene).front();
  CHECK(first ==
        "for an error of 10 % in Q: " + words(nearer[0].rung, scene) +
            ", 1 s (error at most 7.7 % at this rung and all finer ones; finest rung: error bar 2.2 % "
            "from the step only, error of the size unknown)");
  // Of a chatter nothing is known but how much it is.
  const std::vector<RungResult> chatter = chain({{1, 1}, {2, 1.004}, {4, 0.998}, {8, 1.001}});
  const Errors found_chatter = errors(D, chatter, {});
  CHECK_THAT(found_chatter.bar->value, WithinRel(3 * 0.006, 1e-9));
  CHECK_FALSE(found_chatter.bar->asymptotic);
  CHECK(sentences(found_chatter, chatter, scene)[2].starts_with("an error of 1 % in Q is not reached by"));
}

TEST_CASE("what has no size gives no relative error, and what is no number no error at all", "[study]") {
  const scene::Scene scene = test::parse(test::source("scenes/half-disc.toml"));
  for (const Quantity& quantity : {Q, F}) {
    // Beside a finest rung of zero, such as of a force that never came.
    const std::vector<RungResult> to_zero = chain({{1, 0.5}, {2, 0}, {3, 0}});
    const Errors zero = errors(quantity, to_zero, {});
    CHECK(zero.error == std::vector<std::optional<double>>{std::nullopt, 0.0, std::nullopt});
    CHECK(zero.pareto == std::vector<bool>{false, true, false});
    CHECK(sentences(zero, to_zero, scene).front().starts_with("no recommendation"));
    CHECK(orders(quantity, to_zero, {}).empty());
    // The finest is no number: the finest that is one takes its place.
    const std::vector<RungResult> spoilt =
        chain({{1, 1.5}, {2, no_number}, {3, 1}, {4, std::numeric_limits<double>::infinity()}});
    const Errors found = errors(quantity, spoilt, {});
    CHECK(found.reference == std::size_t(2));
    CHECK(found.error == std::vector<std::optional<double>>{0.5, std::nullopt, std::nullopt, std::nullopt});
    CHECK(found.pareto == std::vector<bool>{false, false, false, false});
    CHECK(sentences(found, spoilt, scene) ==
          std::vector<std::string>{"no recommendation for " + quantity.title +
                                   ": the finer rungs have no value"});
    // Nothing is a number.
    const std::vector<RungResult> lost = chain({{1, no_number}, {2, no_number}});
    CHECK_FALSE(errors(quantity, lost, {}).reference);
    CHECK(sentences(errors(quantity, lost, {}), lost, scene).empty());
  }
  // An estimate of J's error beside a J of zero.
  Measured none;
  none.numbers["J"] = 0;
  none.estimate = {1e-3, 1e-3, 0, 0};
  const std::vector<RungResult> alone{{{1, 10, 1, scene::ContactScheme::contact_implicit}, none}};
  CHECK_FALSE(errors({"J", "J", ""}, alone, {}).estimate[0]);
}

TEST_CASE("a ladder that has run in part says no more than it knows", "[study]") {
  std::vector<RungResult> results = runs(0.001, 2, 0.03, 1);
  for (std::size_t i = 3; i < results.size(); ++i)
    results[i].measured.reset();
  const scene::Scene scene = test::parse(test::source("scenes/half-disc.toml"));
  const Errors found = errors(Q, results, {});
  CHECK(*found.reference == 2);
  CHECK_FALSE(found.error[5]);
  CHECK_FALSE(found.pareto[5]);
  CHECK_FALSE(orders(Q, results, {})[0].space);
  for (std::size_t i = 1; i < results.size(); ++i)
    results[i].measured.reset();
  CHECK(orders(Q, results, {}).empty());
  CHECK(errors(Q, results, {}).reference == std::size_t(0));
  CHECK(sentences(errors(Q, results, {}), results, scene).empty());
  results[0].measured.reset();
  CHECK_FALSE(errors(Q, results, {}).reference);
}

TEST_CASE("a scheme that is named holds for every contact, and without one each stays as it is", "[study]") {
  scene::Scene scene = test::parse(test::source("tests/data/block.toml"));
  scene.contacts.push_back(scene.contacts.front());
  scene.contacts[0].mass = scene::ContactMass::massless;
  const auto masses = [&](const Choice& choice) {
    std::vector<std::pair<bool, bool>> found;
    for (const Rung& rung : all_rungs(scene, choice)) {
      const scene::Scene changed = on_rung(scene, rung);
      CHECK(changed.contact_scheme() == rung.scheme);
      found.emplace_back(changed.contacts[0].massless(), changed.contacts[1].massless());
    }
    return found;
  };
  using Masses = std::vector<std::pair<bool, bool>>;
  const std::vector<double> size{0.25}, step{0.02};
  CHECK(masses({size, step, {}, {}}) == Masses{{true, false}});
  CHECK(scheme_and_mass(scene, all_rungs(scene, {size, step, {}, {}}).front().scheme).mass == "mixed");
  CHECK(masses({size, step, {}, {"contact-implicit", "contact-stabilized", "massless"}}) ==
        Masses{{false, false}, {false, false}, {true, true}});
  scene.contacts[1].mass = scene::ContactMass::massless;
  CHECK(masses({size, step, {}, {}}) == Masses{{true, true}});
  CHECK(scheme_and_mass(scene, all_rungs(scene, {size, step, {}, {}}).front().scheme).mass == "massless");
  for (scene::Contact& contact : scene.contacts)
    contact.mass = scene::ContactMass::massless_tangential;
  scene.time.scheme = scene::TimeScheme::contact_stabilized;
  for (const scene::ContactScheme scheme :
       {scene::ContactScheme::contact_stabilized, scene::ContactScheme::contact_implicit}) {
    Rung rung = own_rung(scene);
    rung.scheme = scheme;
    CHECK(scheme_and_mass(scene, scheme).mass == scene::name(on_rung(scene, rung).contacts[1].mass));
  }
}

TEST_CASE("units are those of the plane or of space, and of several obstacles each has its own quantities",
          "[study]") {
  scene::Scene scene = test::parse(test::source("tests/data/block.toml"));
  const auto unit = [&](const char* name, int dim) { return chosen(scene, {name}, dim).front().unit; };
  CHECK(unit("impulse", 2) == "N s/m");
  CHECK(unit("impulse", 3) == "N s");
  CHECK(unit("peak_force", 2) == "N/m");
  CHECK(unit("peak_force", 3) == "N");
  CHECK(unit("contact_time", 2) == "s");
  CHECK_THROWS_AS(unit("impulse_2", 2), UserError);
  scene.contacts.push_back(scene.contacts.front());
  CHECK(unit("impulse_2", 2) == "N s/m");
  CHECK_THROWS_AS(unit("impulse_3", 2), UserError);
}

TEST_CASE("steps that the motion chooses are a family of their own", "[study]") {
  scene::Scene scene = test::parse(test::source("tests/data/block.toml"));
  std::vector<Rung> both = all_rungs(scene, {{1}, {}, {}, {}, {1e-2}});
  CHECK(std::ranges::count_if(both, &Rung::has_varying_steps) == 1);
  CHECK(both.size() == 4);
  scene.time.step = 0, scene.time.steps = 0, scene.time.tolerance = 1e-2;
  const std::vector<Rung> chosen = all_rungs(scene, {{1}, {}, {}, {}});
  REQUIRE(chosen.size() == 3);
  CHECK(chosen.front().tolerance == 1e-2);
  CHECK_THAT(chosen.back().tolerance, WithinRel(0.16, 1e-12));
  CHECK(chosen.back().with_steps(4).tolerance == scene::Time::most_tolerance);
  CHECK(on_rung(scene, chosen.back()).time.automatic());
  CHECK(on_rung(scene, {.size = 1, .steps = 7}).time.step == scene.time.end / 7);
  for (const double wrong : {0.0, 0.6, std::nan("")}) {
    CAPTURE(wrong);
    CHECK_THROWS_AS(all_rungs(scene, {{1}, {}, {}, {}, {wrong}}), UserError);
  }

  // Of 1 + 1/N and of 1 + tolerance, which is the square of their width: orders 1 and 2.
  std::vector<RungResult> results;
  for (int steps : {10, 20, 40})
    results.push_back(run(1, steps, steps, 1 + 1.0 / steps));
  for (int steps : {30, 60, 120}) {
    results.push_back(run(1, steps, steps, 1 + 9.0 / (steps * steps)));
    results.back().rung.steps = 0;
    results.back().rung.tolerance = 9.0 / (steps * steps);
  }
  const std::vector<Orders> found = orders(Q, results, {});
  REQUIRE(found.size() == 2);
  CHECK_FALSE(found[0].varying_steps);
  CHECK(found[1].varying_steps);
  CHECK_THAT(found[0].time->slope, WithinAbs(1, 1e-9));
  CHECK_THAT(found[1].time->slope, WithinAbs(2, 1e-9));
  const Errors against = errors(Q, results, {});
  CHECK(against.reference == 5); // the smaller error bar
  CHECK_THAT(*against.envelope[0], WithinRel((0.1 - 9.0 / 14400) / (1 + 9.0 / 14400), 1e-9));
  for (int steps : {10, 20, 40}) // of the smallest size, though their error bar is the larger one
    results.push_back(run(0.5, steps, 4 * steps, 1 + 1.0 / steps));
  CHECK(errors(Q, results, {}).reference == 8);
}

TEST_CASE("graded meshes are a family of their own", "[study]") {
  scene::Scene scene = test::parse(test::source("tests/data/block.toml"));
  const Choice choice{.sizes = {1, 0.5}, .steps = {0.1}, .degrees{}, .schemes{}, .graded = true};
  const std::vector<Rung> both = all_rungs(scene, choice);
  REQUIRE(both.size() == 4);
  CHECK(std::ranges::count_if(both, &Rung::graded) == 2);
  scene.mesh.graded = "/some/graded.geo";
  const double own = *scene.mesh.size;
  for (const Rung& rung : both) {
    const scene::Mesh mesh = on_rung(scene, rung).mesh;
    CHECK((mesh.file == scene.mesh.graded) == rung.graded);
    CHECK((rung.graded ? mesh.scale * own : *mesh.size) == rung.size);
    CHECK(mesh.size.has_value() != rung.graded);
  }
  scene.mesh.file = "/some/mesh.msh";
  CHECK_THROWS_AS(all_rungs(scene, {.graded = true}), UserError);

  // Of 1 + h and of 1 + h²/2.
  std::vector<RungResult> results;
  for (const double size : {1.0, 0.5, 0.25}) {
    results.push_back(run(size, 10, 1 / size, 1 + size));
    results.push_back(run(size, 10, 1 / size, 1 + size * size / 2));
    results.back().rung.graded = true;
  }
  const std::vector<Orders> found = orders(Q, results, {});
  REQUIRE(found.size() == 2);
  CHECK_FALSE(found[0].graded);
  CHECK(found[1].graded);
  CHECK_THAT(found[0].space->slope, WithinAbs(1, 1e-9));
  CHECK_THAT(found[1].space->slope, WithinAbs(2, 1e-9));
  CHECK(errors(Q, results, {}).reference == 5); // the smaller error bar
}

TEST_CASE("steps that no number could count are refused", "[study]") {
  const scene::Scene scene = test::parse(test::source("tests/data/block.toml"));
  const double most = scene::Time::most_steps;
  CHECK(all_rungs(scene, {{1}, {scene.time.end / most}, {}, {}}).front().steps == scene::Time::most_steps);
  CHECK(all_rungs(scene, {{1}, {10 * scene.time.end}, {}, {}}).front().steps == 1);
  for (const double step : {scene.time.end / (2 * most), 1e-20, 1e-300}) {
    CAPTURE(step);
    CHECK_THROWS_AS(all_rungs(scene, {{1}, {step}, {}, {}}), UserError);
  }
}

TEST_CASE("sampling ends on a mesh that sets its own density, in whole or in part", "[study]") {
  if (ranks(MPI_COMM_WORLD) > 2)
    return;                                            // one rank meshes, which takes the time
  constexpr std::size_t per_cell = 3, wanted = 12'000; // of the quadrature's points
  for (const auto& [file, size, least] :
       {std::tuple{"tests/data/fixed-density.geo", std::optional<double>(0.25), 2 * 70 * 70},
        {"tests/data/fixed-density.geo", std::nullopt, 2 * 70 * 70},
        {"tests/data/fixed-top.geo", 1, 5000}}) {
    scene::Scene scene = test::parse(test::source("tests/data/block.toml"));
    scene.mesh.file = test::source(file);
    scene.mesh.size = size;
    const SamplePoints samples(MPI_COMM_WORLD, scene);
    CHECK(samples.body.weights.size() >= per_cell * static_cast<std::size_t>(least));
    REQUIRE(samples.body.weights.size() > wanted); // coarser meshes were looked for
  }
}

TEST_CASE("sizes that do not change the mesh are refused where they are needed", "[study]") {
  if (ranks(MPI_COMM_WORLD) > 2)
    return; // one rank meshes, which takes the time
  scene::Scene scene = test::parse(test::source("tests/data/block.toml"));
  CHECK_NOTHROW(require_size_takes_effect(MPI_COMM_WORLD, scene));
  CHECK_NOTHROW(require_sizes_take_effect(MPI_COMM_WORLD, scene, {0.25, 0.5, 0.25}));
  scene.mesh.size = 5; // two triangles, as with twice the size, and more with half a metre
  CHECK_NOTHROW(require_sizes_take_effect(MPI_COMM_WORLD, scene, {5, 0.5}));
  CHECK_THROWS_AS(require_sizes_take_effect(MPI_COMM_WORLD, scene, {0.5, 5, 10}), UserError);
  scene.mesh.file = test::source("tests/data/fixed-top.geo");
  scene.mesh.size = 4; // as one of 8, but finer ones change the mesh
  CHECK_NOTHROW(require_sizes_take_effect(MPI_COMM_WORLD, scene, {4, 0.5}));
  scene.mesh.file = test::source("tests/data/fixed-density.geo");
  CHECK_THROWS_AS(require_size_takes_effect(MPI_COMM_WORLD, scene), UserError);
  CHECK_THROWS_AS(require_sizes_take_effect(MPI_COMM_WORLD, scene, {4, 0.25}), UserError);
  CHECK_NOTHROW(require_sizes_take_effect(MPI_COMM_WORLD, scene, {0.25, 0.25}));
  scene.mesh.size.reset();
  CHECK_THROWS_AS(require_size_takes_effect(MPI_COMM_WORLD, scene), UserError);
}
