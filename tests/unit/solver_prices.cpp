// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/collective.h"
#include "contact_parts.h"
#include "step/solver_choice.h"
#include <array>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>

using namespace signorini;
using test::Parts;

TEST_CASE("two packages agree on the work of a factorisation", "[forward]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // CHOLMOD factorises on one rank
  const Parts parts({"mesh.size=0.01"});
  const FactorWork mumps = MumpsSolver(parts.D).work(), cholmod = SparseCholesky(parts.D, {}).work();
  REQUIRE(cholmod.entries > 1e5);
  // They order the unknowns each in its own way, and MUMPS stores and works on whole fronts.
  CHECK(std::abs(std::log(mumps.entries / cholmod.entries)) < std::log(3));
  CHECK(std::abs(std::log(mumps.flops / cholmod.flops)) < std::log(3));
}

TEST_CASE("a trial of conjugate gradients ends at its limit, and counts no solve", "[forward]") {
  const Parts parts({"mesh.size=0.05"});
  const ConjugateGradients D(parts.D);
  const double work = D.trial_work();
  CHECK(work > 1);
  CHECK(std::isfinite(work));
  for (double other : gather(MPI_COMM_WORLD, std::vector<double>{work}))
    CHECK(other == work);
  CHECK(ConjugateGradients(parts.D, 1, work).trial_work() == work);
  CHECK(std::isinf(ConjugateGradients(parts.D, 1, work - 1).trial_work()));
  const petsc::Vector r = parts.pressing(0); // and the next solve is none
  petsc::Vector x = parts.space.vector(), back = parts.space.vector();
  D.solve(r, x);
  petsc::check(MatMult(parts.D, x, back));
  CHECK(test::difference(back, r) < 1e-9 * test::largest(r));
}

TEST_CASE("an iteration reads the matrix and some vectors", "[forward]") {
  const Parts coarse({"mesh.size=0.05"}), fine({"mesh.size=0.025"});
  const auto bytes = [](const Parts& parts) { return ConjugateGradients::iteration_bytes(parts.D); };
  CHECK(bytes(coarse) > petsc::bytes(coarse.D));
  PetscInt few = 0, many = 0;
  petsc::check(MatGetSize(coarse.D, &few, nullptr));
  petsc::check(MatGetSize(fine.D, &many, nullptr));
  const double unknowns = static_cast<double>(many) / few;
  REQUIRE(unknowns > 3);
  CHECK(std::abs(bytes(fine) / bytes(coarse) / unknowns - 1) < 0.1);
}

TEST_CASE("the more solves, the less may one of conjugate gradients take", "[forward]") {
  const step::Price direct{.setup = 30, .solve = 0.1};
  constexpr double bytes = 1e7;
  const int ranks = GENERATE(1, 4);
  CAPTURE(ranks);
  double before = step::affordable(direct, 1, bytes, ranks);
  for (double solves : {10., 100., 1e3, 1e4, 1e6}) {
    const double most = step::affordable(direct, solves, bytes, ranks);
    CHECK(most < before);
    // At that price they are clearly quicker on the whole, and in the end in each solve.
    CHECK(step::iterative_price(most, bytes, ranks).total(solves) < direct.total(solves) / 1.1);
    before = most;
  }
  CHECK(step::iterative_price(before, bytes, ranks).solve < direct.solve);
  CHECK(std::abs(step::affordable(direct, 10, bytes, ranks) / step::affordable(direct, 10, bytes, 1) / ranks -
                 1) < 1e-12);
}

TEST_CASE("the price of a factor grows with its work, and ranks share it", "[forward]") {
  const step::DirectWork work({.flops = 1e10, .entries = 1e7}, 100, 200),
      more({.flops = 1e10, .entries = 2e7}, 100, 0);
  CHECK(step::price(more, 1).solve > step::price(work, 1).solve);
  CHECK(step::price(more, 1).setup > step::price(work, 1).setup); // for its columns
  const int ranks = GENERATE(2, 8);
  CAPTURE(ranks);
  CHECK(step::price(work, 2 * ranks).setup == step::price(work, ranks).setup / 2);
  CHECK(step::price(work, 2 * ranks).solve == step::price(work, ranks).solve / 2);
}

TEST_CASE("the price of MUMPS is estimated before its analysis", "[forward]") {
  const Parts coarse({"mesh.size=0.01"}), fine({"mesh.size=0.005"});
  const int size = ranks(MPI_COMM_WORLD);
  const step::Price small = step::expected_mumps_price(coarse.D, size),
                    large = step::expected_mumps_price(fine.D, size);
  PetscInt few = 0, many = 0;
  petsc::check(MatGetSize(coarse.D, &few, nullptr));
  petsc::check(MatGetSize(fine.D, &many, nullptr));
  REQUIRE(many > 3 * few);
  CHECK(std::abs(large.setup / small.setup - static_cast<double>(many) / few) < 1e-12 * many / few);
  const double analysed = step::price({MumpsSolver(fine.D).work(), 0, 0}, size).solve;
  CHECK(std::abs(std::log(large.solve / analysed)) < std::log(3));
}

TEST_CASE("a small factorisation is not compared with conjugate gradients", "[forward]") {
  const Parts parts({"mesh.size=0.02"});
  const FactorWork work = MumpsSolver(parts.D).work();
  CHECK(step::DirectWork(work, parts.pairs.count(), 0).small());
  CHECK(step::DirectWork(work, parts.pairs.count(), 2.0 * parts.pairs.count()).small());
  CHECK_FALSE(step::DirectWork(work, 1e4, 0).small()); // for its candidates
  CHECK_FALSE(step::DirectWork(work, 1e4, 2e4).small());
  const step::SolverChoice solver(Parts::copy(parts.D), &parts.pairs, parts.scene.solver, true, 1e6);
  CHECK_FALSE(solver.iterates());
  CHECK(solver.choice().find("estimated") == std::string::npos);
}

TEST_CASE("the least that a factor takes is less than it takes, and no analysis precedes it", "[forward]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return;
  for (const auto& [file, sizes] : {std::pair("tests/data/block.toml", std::array{"0.05", "0.0125"}),
                                    {"tests/data/cube.toml", std::array{"0.1", "0.05"}}}) {
    double before = 0;
    for (const std::string size : sizes) {
      INFO(file << ", size " << size);
      const Parts parts({"mesh.size=" + size}, 0, file);
      const double least = step::least_factor_bytes(parts.D), needed = SparseCholesky(parts.D, {}).estimate();
      CHECK(least > before);
      CHECK(least < needed);
      CHECK(least > needed / 50);
      before = least;
      scene::Solver little = parts.scene.solver;
      little.memory = 0.9 * least;
      const step::SolverChoice solver(Parts::copy(parts.D), &parts.pairs, little, true, 10);
      CHECK(solver.iterates());
      CHECK(solver.choice().find("at least") != std::string::npos);
    }
  }
}

TEST_CASE("conjugate gradients take multigrid for long steps alone, and find the same", "[forward]") {
  for (const bool is_long : {false, true}) {
    INFO("long steps: " << is_long);
    const Parts parts({"mesh.size=0.02", is_long ? "time.step=20" : "time.step=0.002",
                       is_long ? "time.end=200" : "time.end=0.02"});
    fem::attach_rigid_motions(parts.D, parts.space);
    constexpr double solves = 100;
    const ConjugateGradients D(parts.D, solves);
    CHECK(D.name() == (is_long ? "CG with gamg" : "CG with pbjacobi"));
    CHECK(D.bytes() > 0);
    const petsc::Vector y = test::smooth(parts.space, 1);
    petsc::Vector r = petsc::zero_like(y), x = petsc::zero_like(y);
    petsc::check(MatMult(parts.D, y, r));
    D.solve(r, x);
    CHECK(test::difference(x, y) < 1e-8 * test::largest(y)); // 1e-12 of the energy norm, by the condition
  }
}
