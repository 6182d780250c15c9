#include "base/error.h"
#include "fem/sampler.h"
#include "fixtures.h"
#include "study/density.h"
#include "study/measure.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>

using namespace signorini;
using namespace signorini::study;
using Catch::Matchers::WithinAbs, Catch::Matchers::WithinRel;

namespace {

/// Runs of sizes h and N steps with the number Q = 1 + a h^p + b N^-q.
std::vector<Result> runs(double a, double p, double b, double q) {
  std::vector<Result> results;
  for (double size : {4.0, 2.0, 1.0, 0.5})
    for (int steps : {10, 20, 40, 80}) {
      Measured run;
      run.seconds = steps / (size * size);
      run.numbers["Q"] = 1 + a * std::pow(size, p) + b * std::pow(steps, -q);
      results.push_back({{size, steps, 1, "contact-implicit"}, run});
    }
  return results;
}

const Quantity Q{"Q", "Q", "", false, false};

} // namespace

TEST_CASE("samples are the same on any number of ranks, and those of functions of V exact", "[study]") {
  for (const char* file : {"tests/data/block.toml", "tests/data/cube.toml"})
    for (const char* degree : {"mesh.degree=1", "mesh.degree=2"}) {
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
      const auto line = [](const double* x, std::size_t c) { return 1 + x[0] - 2 * x[1] + 3 * x[2] + static_cast<double>(c); };
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

TEST_CASE("orders in space and time come apart, and errors are against what is known", "[study]") {
  const std::vector<Result> results = runs(0.001, 2, 0.03, 1);
  const std::vector<Orders> found = orders(Q, results, {});
  REQUIRE(found.size() == 1);
  CHECK_THAT(found[0].space->slope, WithinAbs(2, 0.01)); // differences are relative to values that differ by 2 %
  CHECK_THAT(found[0].time->slope, WithinAbs(1, 0.01));
  const Errors against_finest = errors(Q, results, {});
  REQUIRE(against_finest.reference);
  CHECK(results[*against_finest.reference].rung.size == 0.5);
  CHECK(results[*against_finest.reference].rung.steps == 80);
  CHECK_FALSE(against_finest.error[*against_finest.reference]);
  const Errors against_exact = errors(Q, results, {{{"Q", 1}}, {}});
  CHECK_FALSE(against_exact.reference);
  for (std::size_t i = 0; i < results.size(); ++i) {
    CHECK_THAT(*against_exact.error[i], WithinRel(results[i].measured->numbers.at("Q") - 1, 1e-12));
    if (against_exact.effectivity[i]) // both parts of the model have the same sign
      CHECK_THAT(*against_exact.effectivity[i], WithinAbs(1, 0.05)); // relative to the run's own value, 2 % off at most
  }
  CHECK(std::ranges::count_if(against_exact.effectivity, [](const auto& value) { return value.has_value(); }) == 9);
}

TEST_CASE("no rung of the front is beaten in both, and every other one is", "[study]") {
  const std::vector<Result> results = runs(0.001, 2, 0.03, 1);
  const Errors found = errors(Q, results, {{{"Q", 1}}, {}});
  for (std::size_t i = 0; i < results.size(); ++i) {
    bool beaten = false;
    for (std::size_t j = 0; j < results.size(); ++j)
      beaten |= results[j].measured->seconds < results[i].measured->seconds && *found.error[j] <= *found.error[i];
    CHECK(found.pareto[i] == !beaten);
  }
}

TEST_CASE("a ladder that has run in part says no more than it knows", "[study]") {
  std::vector<Result> results = runs(0.001, 2, 0.03, 1);
  for (std::size_t i = 3; i < results.size(); ++i)
    results[i].measured.reset();
  const scene::Scene scene = test::parse(test::source("scenes/half-disc.toml"));
  const Errors found = errors(Q, results, {});
  CHECK(*found.reference == 2);
  CHECK_FALSE(found.error[5]);
  CHECK_FALSE(orders(Q, results, {})[0].space);
  for (std::size_t i = 1; i < results.size(); ++i)
    results[i].measured.reset();
  CHECK(orders(Q, results, {}).empty());
  CHECK(sentences(errors(Q, results, {}), results, scene).empty());
}

TEST_CASE("sampling ends on a mesh that sets its own density, in whole or in part", "[study]") {
  constexpr std::size_t per_cell = 3, wanted = 12'000; // of the quadrature's points
  for (const auto& [file, size, least] : {std::tuple{"tests/data/fixed-density.geo", std::optional<double>(0.25), 2 * 70 * 70},
                                          {"tests/data/fixed-density.geo", std::nullopt, 2 * 70 * 70},
                                          {"tests/data/fixed-top.geo", 1, 5000}}) {
    scene::Scene scene = test::parse(test::source("tests/data/block.toml"));
    scene.mesh.file = test::source(file);
    scene.mesh.size = size;
    const Samples samples(MPI_COMM_WORLD, scene);
    CHECK(samples.body.weights.size() >= per_cell * static_cast<std::size_t>(least));
    REQUIRE(samples.body.weights.size() > wanted); // coarser meshes were looked for
  }
}

TEST_CASE("sizes that do not change the mesh are refused where they are needed", "[study]") {
  scene::Scene scene = test::parse(test::source("tests/data/block.toml"));
  CHECK_NOTHROW(require_answer(MPI_COMM_WORLD, scene));
  CHECK_NOTHROW(require_answer_to(MPI_COMM_WORLD, scene, {0.25, 0.5, 0.25}));
  scene.mesh.size = 50; // two triangles, as with twice the size, and more with half a metre
  CHECK_NOTHROW(require_answer_to(MPI_COMM_WORLD, scene, {50, 0.5}));
  CHECK_THROWS_AS(require_answer_to(MPI_COMM_WORLD, scene, {0.5, 50, 100}), UserError);
  scene.mesh.file = test::source("tests/data/fixed-top.geo");
  scene.mesh.size = 4; // as one of 8, but finer ones change the mesh
  CHECK_NOTHROW(require_answer_to(MPI_COMM_WORLD, scene, {4, 0.5}));
  scene.mesh.file = test::source("tests/data/fixed-density.geo");
  CHECK_THROWS_AS(require_answer(MPI_COMM_WORLD, scene), UserError);
  CHECK_THROWS_AS(require_answer_to(MPI_COMM_WORLD, scene, {4, 0.25}), UserError);
  CHECK_NOTHROW(require_answer_to(MPI_COMM_WORLD, scene, {0.25, 0.25}));
  scene.mesh.size.reset();
  CHECK_THROWS_AS(require_answer(MPI_COMM_WORLD, scene), UserError);
}
