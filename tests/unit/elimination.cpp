// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/collective.h"
#include "base/error.h"
#include "base/machine.h"
#include "contact/condensation.h"
#include "contact_parts.h"
#include "linalg/threaded_product.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <fmt/format.h>
#include <functional>
#include <optional>

using namespace signorini;
using petsc::check;
using test::Parts;

namespace {

std::vector<double> condensed(const contact::Condensation& condensation, int rows) {
  std::vector<double> S;
  for (int i = 0; i < rows; ++i)
    S.insert(S.end(), condensation.column(i).begin(), condensation.column(i).end());
  return S;
}

} // namespace

TEST_CASE("the condensed matrix is what D says", "[contact]") {
  const Parts parts;
  MumpsSolver D(parts.D);
  D.factorise();
  const contact::StoredColumnsCondensation columns(parts.pairs.rows(), D, parts.space.vector(), 1e9),
      solves(parts.pairs.rows(), D, parts.space.vector(), 0);
  CHECK(columns.bytes() > 0);
  CHECK(solves.bytes() == 0);
  const std::size_t m = static_cast<std::size_t>(parts.pairs.count());
  std::vector<double> lambda{1, -2, 0.5, 3, 0.1}, minus(m), slip(m);
  std::ranges::transform(lambda, minus.begin(), std::negate{});
  petsc::Vector y = parts.space.vector(), zero = parts.space.vector(), direct = parts.space.vector(),
                force = parts.space.vector();
  parts.H.apply(1, lambda, force);
  D.solve(force, direct);
  for (const contact::StoredColumnsCondensation* condensation : {&columns, &solves}) {
    contact::HalfSolve half_solve = condensation->half_solve();
    condensation->predict(zero, {}, half_solve, slip);
    CHECK(std::ranges::all_of(slip, [](double s) { return s == 0; }));
    condensation->finish(half_solve, minus, y);
    CHECK(test::difference(y, direct) < 1e-13 * test::largest(direct));
    parts.H.apply_transpose(y, slip);
    const std::vector<double> S = condensed(*condensation, static_cast<int>(m));
    for (std::size_t i = 0; i < m; ++i) {
      double product = 0;
      for (std::size_t j = 0; j < m; ++j)
        product += S[i * m + j] * lambda[j];
      CHECK(std::abs(product / slip[i] - 1) < 1e-12);
    }
  }
}

TEST_CASE("solves are the same to the last bit on any number of threads", "[contact]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // CHOLMOD factorises on one rank
  const int before = threads();
  const Parts parts({"mesh.size=0.01", "contact.on=boundary", "contact.obstacle.point=[0, -9]"});
  std::vector<int> trailing_block;
  for (PetscInt dof : parts.pairs.first_dofs())
    trailing_block.push_back(static_cast<int>(dof / 2));
  const petsc::Vector r = parts.pressing(1);
  std::vector<double> first;
  for (int n : {1, 2, 3, 7}) {
    CAPTURE(n);
    use_threads(MPI_COMM_WORLD, n);
    SparseCholesky cholesky(parts.D, trailing_block);
    cholesky.factorise();
    petsc::Vector y = parts.space.vector(), residual = parts.space.vector();
    cholesky.solve(r, y);
    check(MatMult(parts.D, y, residual));
    CHECK(test::difference(residual, r) < 1e-11 * test::largest(r));
    const petsc::ReadArray values(y);
    const std::vector<double> now(std::span<const double>(values).begin(),
                                  std::span<const double>(values).end());
    if (n == 1)
      first = now;
    CHECK(now == first);
  }
  use_threads(MPI_COMM_WORLD, before);
}

TEST_CASE("products are PETSc's, and the same to the last bit on any number of threads", "[contact]") {
  const bool one_rank = ranks(MPI_COMM_WORLD) == 1;
  const int before = threads();
  for (const auto& [file, settings] :
       {std::pair{"tests/data/block.toml", std::vector<std::string>{"mesh.size=0.01"}},
        {"tests/data/two-materials.toml", {"mesh.size=0.012"}},
        {"tests/data/cube.toml", {"mesh.size=0.06"}},
        {"tests/data/block.toml", {}},
        {"tests/data/cube.toml", {}}}) { // these two are too small for threads
    const scene::Scene scene = test::parse(test::source(file), settings);
    const fem::Space& space = test::discretised(scene)->space;
    const fem::Operators threaded = fem::assemble_operators(space, scene.materials, true);
    petsc::Matrix plain_A, plain_M;
    check(MatConvert(threaded.A, MATBAIJ, MAT_INITIAL_MATRIX, plain_A.put()));
    check(MatConvert(threaded.M, MATAIJ, MAT_INITIAL_MATRIX, plain_M.put()));
    petsc::Vector x = space.vector(), z = space.vector(), y = space.vector(), expected = space.vector(),
                  first = space.vector();
    check(VecSetRandom(x, nullptr));
    check(VecSetRandom(z, nullptr));
    for (const auto& [mine, theirs] :
         {std::pair{Mat(threaded.A), Mat(plain_A)}, {Mat(threaded.M), Mat(plain_M)}}) {
      for (const bool added : {false, true})
        for (int n : {1, 2, 3, 5}) {
          CAPTURE(added, n);
          use_threads(MPI_COMM_WORLD, n);
          if (added) {
            check(MatMultAdd(theirs, x, z, expected));
            check(VecCopy(z, y));
            check(MatMultAdd(mine, x, y, y)); // in place
          } else {
            check(MatMult(theirs, x, expected));
            check(MatMult(mine, x, y));
          }
          CHECK(test::difference(y, expected) < 1e-13 * test::largest(expected));
          if (n == 1)
            check(VecCopy(y, first));
          // Ranks add each other's contributions in the order of their arrival.
          CHECK(test::difference(y, first) <= (one_rank ? 0 : 1e-14 * test::largest(expected)));
        }
      if (!one_rank && mine == Mat(threaded.M))
        continue; // PETSc's products
      Mat own_block = mine;
      if (!one_rank)
        check(MatGetDiagonalBlock(mine, &own_block));
      PetscObject own = nullptr;
      check(PetscObjectQuery(reinterpret_cast<PetscObject>(own_block), "signorini_threaded_product", &own));
      CHECK(own);
    }
  }
  use_threads(MPI_COMM_WORLD, before);
}

TEST_CASE("contact in the corner of the factor is contact everywhere", "[contact]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // CHOLMOD factorises on one rank
  // On both sides of the size from which CHOLMOD works on supernodes.
  const char* size = GENERATE(as<const char*>{}, "mesh.size=0.2", "mesh.size=0.01");
  CAPTURE(size);
  const Parts parts({size, "contact.on=boundary", "contact.obstacle.point=[0, -9]"});
  const int m = parts.pairs.count();
  std::vector<int> trailing_block;
  for (PetscInt dof : parts.pairs.first_dofs())
    trailing_block.push_back(static_cast<int>(dof / 2));
  SparseCholesky cholesky(parts.D, trailing_block);
  const double estimate = cholesky.estimate();
  cholesky.factorise();
  CHECK(cholesky.bytes() < 1.2 * estimate);
  CHECK(cholesky.bytes() > 0.5 * estimate);
  MumpsSolver mumps(parts.D);
  mumps.factorise();
  const contact::TrailingBlockCondensation fast(parts.pairs.rows(), cholesky);
  const contact::StoredColumnsCondensation slow(parts.pairs.rows(), mumps, parts.space.vector(), 0);
  const std::vector<double> S = condensed(fast, parts.pairs.count()),
                            T = condensed(slow, parts.pairs.count());
  double worst = 0;
  for (std::size_t i = 0; i < S.size(); ++i)
    worst = std::max(worst, std::abs(S[i] - T[i]));
  CHECK(worst < 1e-12 * *std::ranges::max_element(T));
  const petsc::Vector r = parts.pressing(1);
  petsc::Vector y = parts.space.vector(), z = parts.space.vector(), target = parts.space.vector();
  mumps.solve(r, target);
  std::vector<double> a(static_cast<std::size_t>(m)), b(a.size()), lambda(a.size());
  contact::HalfSolve of_fast = fast.half_solve(), of_slow = slow.half_solve();
  fast.predict(r, {}, of_fast, a);
  slow.predict(r, {}, of_slow, b);
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(std::abs(a[i] - b[i]) < 1e-12 * test::largest(target));
    lambda[i] = i % 3 == 0 ? 0.1 * std::cos(static_cast<double>(i)) * test::largest(r) : 0;
  }
  for (const double scale : {1.0, 0.0, -2.0}) { // repeatable
    for (double& force : lambda)
      force *= scale;
    fast.finish(of_fast, lambda, y);
    slow.finish(of_slow, lambda, z);
    CHECK(test::difference(y, z) < 1e-12 * test::largest(z));
  }
}

TEST_CASE("a factor that does not fit the memory allowed is not made", "[contact]") {
  const Parts fits({"mesh.size=0.02", "solver.memory=1e9"}), exceeds({"mesh.size=0.02", "solver.memory=1e5"}),
      forced({"mesh.size=0.02", "solver.memory=1e5", "solver.linear=direct"});
  CHECK(!fits.solver.takes_guess());
  CHECK(fits.solver.memory().factor > 1e5);
  CHECK(exceeds.solver.takes_guess());
  CHECK(exceeds.solver.memory().condensation == 0);
  CHECK(exceeds.solver.choice().find("the limit is 100 kB") != std::string::npos);
  CHECK(!forced.solver.takes_guess());
}

TEST_CASE("MUMPS is given more space where what it set aside falls short", "[contact]") {
  // On several ranks it does at random, as they are loaded. Here it is told to set aside too little.
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // a factorisation that fails there may leave messages to the next one
  const Parts parts({"mesh.size=0.02"});
  MumpsSolver usual(parts.D);
  usual.factorise();
  std::optional<test::Option> relaxation;
  relaxation.emplace("-step_mat_mumps_icntl_14", "-50");
  {
    petsc::Matrix matrix, factor;
    MatFactorInfo info;
    petsc::check(MatConvert(parts.D, MATAIJ, MAT_INITIAL_MATRIX, matrix.put()));
    petsc::check(MatSetOption(matrix, MAT_SPD, PETSC_TRUE));
    petsc::check(MatSetOptionsPrefixFactor(matrix, "step_"));
    petsc::check(MatGetFactor(matrix, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, factor.put()));
    petsc::check(MatFactorInfoInitialize(&info));
    petsc::check(MatCholeskyFactorSymbolic(factor, matrix, nullptr, &info));
    petsc::check(MatCholeskyFactorNumeric(factor, matrix, &info));
    PetscInt error = 0;
    petsc::check(MatMumpsGetInfog(factor, 1, &error));
    REQUIRE(error == -9);
  }
  MumpsSolver tight(parts.D);
  tight.factorise();
  relaxation.reset();
  const petsc::Vector r = parts.pressing(0);
  petsc::Vector x = parts.space.vector(), y = parts.space.vector();
  usual.solve(r, x);
  tight.solve(r, y);
  CHECK(test::difference(x, y) < 1e-12 * test::largest(x));
}

TEST_CASE("a factor with more entries than can be numbered is not made", "[contact]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // CHOLMOD factorises on one rank
  const Parts parts({"mesh.size=0.02"});
  SparseCholesky few(parts.D, {}), many(parts.D, {}, 1e4);
  CHECK(few.indexable());
  REQUIRE_FALSE(many.indexable());
  CHECK(many.estimate() > 8e4);
  CHECK(many.estimate() < few.estimate());
  CHECK_THROWS_AS(many.factorise(), SolverFailure);
}

TEST_CASE("a direct solver is chosen by the memory of its factor and of two dense matrices of the candidates",
          "[contact]") {
  const std::vector<std::string> many{"mesh.size=0.02", "contact.on=boundary",
                                      "contact.obstacle.point=[0, -9]"};
  const auto with = [&](double memory) {
    std::vector<std::string> settings = many;
    settings.push_back(fmt::format("solver.memory={:.17g}", memory));
    return Parts(settings);
  };
  const Parts parts(many);
  const double m = parts.pairs.count(), dense = 2 * m * m * sizeof(double);
  std::vector<int> trailing_block;
  for (PetscInt dof : parts.pairs.first_dofs())
    trailing_block.push_back(static_cast<int>(dof / 2));
  if (ranks(MPI_COMM_WORLD) > 1) { // MUMPS says whole megabytes, and of another partition of the mesh others
    const double factor = MumpsSolver(parts.D).estimate();
    CHECK_FALSE(with(2 * factor + dense).solver.takes_guess());
    CHECK(with(factor / 2).solver.takes_guess());
    return;
  }
  const double factor = SparseCholesky(parts.D, trailing_block).estimate();
  REQUIRE(dense > 1e-3 * factor); // a hundredth of it is then far beyond the rounding of their sum
  CHECK_FALSE(with(factor + 1.01 * dense).solver.takes_guess());
  CHECK(with(factor + 0.99 * dense).solver.takes_guess());
  // On one rank contact is condensed by the factor's last block, with no column of D⁻¹ to keep for each
  // candidate.
  CHECK(parts.solver.memory().condensation < 0.5 * m * parts.space.dofs() * sizeof(double));
}
