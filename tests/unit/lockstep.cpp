// SPDX-License-Identifier: GPL-3.0-or-later
// Solves of several tasks that are made together.
#include "linalg/lockstep.h"
#include "base/collective.h"
#include "base/machine.h"
#include "contact_parts.h"
#include "fixtures.h"
#include "linalg/lane_product.h"
#include "linalg/sparse_cholesky.h"
#include "problem/problem.h"
#include "trajectory/parameter_sensitivities.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <fmt/format.h>
#include <functional>
#include <numeric>
#include <stdexcept>

using namespace signorini;
using petsc::check;
using test::Parts;

namespace {

std::vector<double> values(Vec x) {
  const petsc::ReadArray read(x);
  return {std::span<const double>(read).begin(), std::span<const double>(read).end()};
}

} // namespace

TEST_CASE("solves made together do not depend on their number, order and threads", "[lockstep]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // CHOLMOD factorises on one rank
  const int before = threads(), n = GENERATE(1, 2, 3);
  CAPTURE(n);
  use_threads(MPI_COMM_WORLD, n);
  const Parts parts({"mesh.size=0.01", "contact.on=boundary", "contact.obstacle.point=[0, -9]"});
  std::vector<int> trailing_block;
  for (PetscInt dof : parts.pairs.first_dofs())
    trailing_block.push_back(static_cast<int>(dof / 2));
  SparseCholesky D(parts.D, trailing_block);
  D.factorise();
  constexpr std::size_t most = 37; // two wide groups, and a narrow one
  std::vector<petsc::Vector> b, x;
  for (std::size_t i = 0; i < most; ++i) {
    b.push_back(parts.pressing(1));
    check(VecSetRandom(b.back(), nullptr));
    x.push_back(parts.space.vector());
  }
  Lockstep lockstep;
  const auto solve = [&](const std::vector<std::size_t>& which) {
    std::vector<std::function<void()>> tasks;
    for (const std::size_t i : which)
      tasks.emplace_back([&, i] { D.solve(b[i], x[i]); });
    D.unite(&lockstep);
    lockstep.run(tasks);
    D.unite(nullptr);
  };
  std::vector<std::size_t> all(most);
  for (std::size_t i = 0; i < most; ++i)
    all[i] = i;
  solve(all);
  std::vector<std::vector<double>> together;
  petsc::Vector alone = parts.space.vector();
  bool differs = false;
  for (std::size_t i = 0; i < most; ++i) {
    together.push_back(values(x[i]));
    D.solve(b[i], alone);
    CHECK(test::difference(alone, x[i]) < 1e-13 * test::largest(alone));
    differs = differs || values(alone) != together.back();
  }
  CHECK(differs); // else the solves were not made together
  for (const std::vector<std::size_t>& which :
       {std::vector<std::size_t>{5},
        {3, 2},
        {36, 0, 17},
        {1, 2, 3, 4, 5, 6, 7, 8, 9},
        {30, 29, 28, 27, 26, 25, 24, 23, 22, 21, 20, 19, 18, 17, 16, 15, 14}}) {
    for (const std::size_t i : which)
      check(VecZeroEntries(x[i]));
    solve(which);
    for (const std::size_t i : which)
      CHECK(values(x[i]) == together[i]);
  }
  use_threads(MPI_COMM_WORLD, before);
}

TEST_CASE("products made together do not depend on their number, order and threads", "[lockstep]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return;
  const int before = threads(), n = GENERATE(1, 2, 3);
  const std::string body = GENERATE("plane", "space");
  const bool masses = GENERATE(false, true); // of blocks rather than of one number for each
  CAPTURE(n, body, masses);
  use_threads(MPI_COMM_WORLD, n);
  const test::Ready ready(body == "plane" ? "scenes/half-disc.toml" : "scenes/half-ball.toml",
                          {body == "plane" ? "mesh.size=2" : "mesh.size=4"});
  const problem::Problem& problem = ready.problem;
  const fem::Space& space = problem.space;
  const auto R = problem.stepper.of_length(ready.scene.time.step).shared_R;
  const petsc::Matrix blocks = symmetric_half(fem::assemble_mass(space, ready.scene.materials));
  const Mat M = masses ? Mat(blocks) : Mat(problem.operators.M);
  LaneProduct product(R, M);
  constexpr std::size_t most = 19;
  std::vector<petsc::Vector> x, w, r;
  for (std::size_t i = 0; i < most; ++i) {
    for (std::vector<petsc::Vector>* all : {&x, &w, &r}) {
      all->push_back(space.vector());
      check(VecSetRandom(all->back(), nullptr));
    }
  }
  Lockstep lockstep;
  const auto multiply = [&](const std::vector<std::size_t>& which) {
    std::vector<std::function<void()>> tasks;
    for (const std::size_t i : which)
      tasks.emplace_back([&, i] { product.multiply(*R, x[i], w[i], r[i]); });
    product.unite(&lockstep);
    lockstep.run(tasks);
    product.unite(nullptr);
  };
  std::vector<std::size_t> all(most);
  std::iota(all.begin(), all.end(), std::size_t{0});
  multiply(all);
  std::vector<std::vector<double>> together;
  const petsc::Vector alone = space.vector();
  bool differs = false;
  for (std::size_t i = 0; i < most; ++i) {
    together.push_back(values(r[i]));
    product.multiply(*R, x[i], w[i], alone);
    CHECK(test::difference(alone, r[i]) < 1e-13 * test::largest(alone));
    differs = differs || values(alone) != together.back();
  }
  CHECK(differs); // else the products were not made together
  for (const std::vector<std::size_t>& which :
       {std::vector<std::size_t>{5}, {3, 2}, {18, 0, 9, 8, 7, 6, 5, 4, 3, 2}}) {
    multiply(which);
    for (const std::size_t i : which)
      CHECK(values(r[i]) == together[i]);
  }
  use_threads(MPI_COMM_WORLD, before);
}

namespace {

/// Writes down with whom it was made.
class Noted final : public SharedSolve {
public:
  Noted(int kind, std::vector<std::size_t>& sizes) : kind_(kind), sizes_(sizes) {}
  void make(std::span<SharedSolve* const> all) override { sizes_.push_back(all.size()); }
  [[nodiscard]] const void* kind() const override { return reinterpret_cast<const void*>(kind_); }

private:
  std::intptr_t kind_;
  std::vector<std::size_t>& sizes_;
};

} // namespace

TEST_CASE("tasks wait for each other, end at different times and may fail", "[lockstep]") {
  Lockstep lockstep;
  std::vector<std::size_t> sizes;
  std::vector<int> ended;
  const auto task = [&](int number, int solves) {
    return [&, number, solves] {
      for (int i = 0; i < solves; ++i) {
        Noted solve(1 + i, sizes);
        lockstep.wait(solve);
        CHECK(lockstep.inside());
      }
      ended.push_back(number);
    };
  };
  lockstep.run({task(0, 1), task(1, 3), task(2, 2), task(3, 0)});
  CHECK(sizes == std::vector<std::size_t>{3, 2, 1});
  CHECK(ended == std::vector<int>{3, 0, 2, 1});
  CHECK_FALSE(lockstep.inside());

  sizes.clear();
  ended.clear();
  const auto failing = [&](const char* what) {
    return [&, what] {
      Noted solve(1, sizes);
      lockstep.wait(solve);
      throw std::runtime_error(what);
    };
  };
  try {
    lockstep.run({task(0, 2), failing("first"), failing("second")});
    FAIL("nothing was thrown");
  } catch (const std::runtime_error& error) {
    CHECK(std::string(error.what()) == "first");
  }
  CHECK(ended == std::vector<int>{0}); // the others end before
}

TEST_CASE("derivatives by several unknowns, made together, are those made alone", "[lockstep]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return;
  const std::string scheme = GENERATE("contact-implicit", "contact-stabilized");
  CAPTURE(scheme);
  const test::Ready ready("tests/data/parameters.toml",
                          {"mesh.size=0.01", "time.end=0.2", fmt::format("time.scheme=\"{}\"", scheme)});
  const problem::Problem& problem = ready.problem;
  const problem::GivenControl given(problem);
  const auto derivatives = [&](const scene::Scene& scene) {
    step::ParameterRates rates(problem.stepper, scene, scene::start_values(scene));
    trajectory::ParameterSensitivities sensitivities(problem.stepper, rates);
    bool touched = false;
    trajectory::integrate(problem.stepper, problem.grid, problem.initial, given.load(),
                          [&](const trajectory::Frame& frame) {
                            touched = touched || !frame.contact.active.empty();
                            sensitivities.observe(frame);
                          });
    REQUIRE(touched);
    std::vector<std::vector<double>> found;
    for (std::size_t j = 0; j < sensitivities.count(); ++j)
      found.push_back(values(sensitivities.y(j)));
    return found;
  };
  const std::vector<std::vector<double>> together = derivatives(ready.scene);
  REQUIRE(together.size() > 5);
  bool differs = false;
  for (std::size_t j = 0; j < together.size(); ++j) {
    CAPTURE(j);
    scene::Scene one = ready.scene;
    one.unknowns = {ready.scene.unknowns[j]};
    const std::vector<double> alone = derivatives(one).front();
    double size = 0, difference = 0;
    for (std::size_t i = 0; i < alone.size(); ++i) {
      size = std::max(size, std::abs(alone[i]));
      difference = std::max(difference, std::abs(alone[i] - together[j][i]));
    }
    CHECK(size > 0);
    CHECK(difference < 1e-12 * size);
    differs = differs || difference > 0;
  }
  CHECK(differs); // else the steps were not made together
}
