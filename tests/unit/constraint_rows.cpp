// SPDX-License-Identifier: GPL-3.0-or-later
// Rows of contact constraints over one node and over several, and the bases of their clusters.
#include "contact/constraint_rows.h"
#include "base/collective.h"
#include "base/petsc.h"
#include "contact/row_basis.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <limits>
#include <numeric>

using namespace signorini;
using contact::ConstraintRows;
using petsc::check;

namespace {

using Rows = std::vector<ConstraintRows::Group>;

/// Rows over all of so many dofs, of which no clamp holds any.
ConstraintRows dense_rows(const std::vector<std::vector<double>>& coefficients) {
  Rows rows;
  for (const std::vector<double>& one : coefficients) {
    rows.emplace_back();
    for (std::size_t c = 0; c < one.size(); ++c)
      rows.back().entries.push_back({static_cast<PetscInt>(c), one[c], false});
  }
  return {MPI_COMM_SELF, rows, 0, static_cast<PetscInt>(coefficients.front().size())};
}

/// A clamped component, a node with three rows of which two depend on each other, and two rows that tie one
/// dof to others with weights, as meshes that do not match are tied.
const Rows mixed{{{{2, 0.6, false}, {3, -0.8, true}}},
                 {{{6, 0, false}, {7, 1, false}}},
                 {{{6, 0, false}, {7, -1, false}}},
                 {{{6, 1, false}, {7, 0, false}}},
                 {{{10, 1, false}, {12, -0.25, false}, {14, -0.75, false}}},
                 {{{11, 1, false}, {14, -0.5, false}, {16, -0.5, false}}}};
constexpr PetscInt dofs = 18;

petsc::Vector numbers(double from) {
  petsc::Vector x;
  check(VecCreateSeq(PETSC_COMM_SELF, dofs, x.put()));
  const petsc::WriteArray values(x);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = std::sin(from + 1.7 * static_cast<double>(i));
  return x;
}

} // namespace

TEST_CASE("rows that share dofs are clusters", "[contact]") {
  const ConstraintRows H(MPI_COMM_SELF, mixed, 0, dofs);
  REQUIRE(H.count() == 6);
  CHECK(H.dofs() == std::vector<PetscInt>{2, 3, 6, 7, 10, 12, 14, 11, 16});
  REQUIRE(H.clusters().size() == 3);
  const std::vector<std::array<int, 4>> expected{{0, 1, 0, 2}, {1, 4, 2, 4}, {4, 6, 4, 9}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const ConstraintRows::Cluster& one = H.clusters()[i];
    CHECK(std::array{one.first, one.last, one.begin, one.end} == expected[i]);
    CHECK(one.dependent == (i == 1));
    CHECK(one.here);
  }
  CHECK((H.dependent() && H.clamped()));
  CHECK_FALSE(ConstraintRows(MPI_COMM_SELF, mixed, dofs, 2 * dofs).clusters()[0].here); // of another rank
}

TEST_CASE("the operator of rows is the transpose of its transpose, but for clamped dofs", "[contact]") {
  const ConstraintRows H(MPI_COMM_SELF, mixed, 0, dofs);
  const std::vector<double> lambda{1, -2, 0.5, 3, 0.25, -1}, psi{0, 1, 2, 3, 4, 5};
  const petsc::Vector x = numbers(0.3), f = petsc::zero_like(x), whole = petsc::zero_like(x);
  std::vector<double> motion(6), gap(6), own(H.dofs().size()), by_own(6);
  H.apply_transpose(x, motion);
  H.apply(2, lambda, f);
  H.apply_whole(2, lambda, whole);
  double product = 0;
  for (std::size_t i = 0; i < 6; ++i)
    product += 2 * lambda[i] * motion[i];
  CHECK(std::abs(petsc::dot(x, whole) - product) < 1e-14);
  const petsc::ReadArray values(x), forces(f), all(whole);
  CHECK((forces[3] == 0 && std::abs(all[3] + 1.6) < 1e-15 && std::abs(forces[2] - 1.2) < 1e-15));
  CHECK(std::abs(forces[14] - 2 * (-0.75 * 0.25 + 0.5)) < 1e-15);
  CHECK(std::abs(motion[4] - (values[10] - 0.25 * values[12] - 0.75 * values[14])) < 1e-15);
  CHECK(std::abs(H.clamped_part(0, values) + 0.8 * values[3]) < 1e-15);
  CHECK(H.clamped_part(5, values) == 0);
  H.gap(psi, x, gap);
  for (std::size_t i = 0; i < 6; ++i)
    CHECK(gap[i] == psi[i] - motion[i]);
  // The same on the constrained dofs alone, and as dense and sparse matrices.
  for (std::size_t j = 0; j < own.size(); ++j)
    own[j] = values[static_cast<std::size_t>(H.dofs()[j])];
  H.apply_transpose(own, by_own);
  CHECK(by_own == motion);
  H.apply(lambda, own);
  const std::vector<double> dense = H.dense();
  for (std::size_t j = 0; j < own.size(); ++j) {
    double sum = 0;
    for (std::size_t i = 0; i < 6; ++i)
      sum += dense[i * own.size() + j] * lambda[i];
    CHECK(std::abs(own[j] - sum) < 1e-15);
    CHECK(std::abs(2 * own[j] - forces[static_cast<std::size_t>(H.dofs()[j])]) < 1e-15);
  }
  const petsc::Matrix sparse = H.rows(1, 4, x);
  petsc::Vector out;
  check(MatCreateVecs(sparse, nullptr, out.put()));
  check(MatMult(sparse, x, out));
  for (std::size_t i = 0; i < 4; ++i)
    CHECK(std::abs(petsc::ReadArray(out)[i] - motion[i + 1]) < 1e-15);
  const std::vector<double> squares = H.weighted_squares(x);
  CHECK(std::abs(squares[0] - 0.36 * values[2]) < 1e-15);
  CHECK(std::abs(squares[4] - (values[10] + 0.0625 * values[12] + 0.5625 * values[14])) < 1e-15);
  std::vector<double> gram;
  H.gram(H.clusters()[2], gram);
  CHECK((gram.size() == 4 && std::abs(gram[0] - 1.625) < 1e-15 && std::abs(gram[1] - 0.375) < 1e-15 &&
         gram[1] == gram[2] && std::abs(gram[3] - 1.5) < 1e-15));
}

TEST_CASE("multipliers are found from their forces, and motions prescribed by the smallest change",
          "[contact]") {
  const ConstraintRows H(MPI_COMM_SELF, mixed, 0, dofs);
  const contact::ActiveSet set{0, 1, 2, 4, 5}; // 2 depends on 1
  const std::vector<double> lambda{1.5, -2, 0, 0, 0.25, -1};
  const petsc::Vector f = numbers(0);
  check(VecZeroEntries(f));
  H.apply(1, lambda, f);
  std::vector<double> found(6), motion(6);
  H.multipliers(set, f, found);
  for (std::size_t i = 0; i < 6; ++i)
    CHECK(std::abs(found[i] - lambda[i]) < 1e-15);
  const petsc::Vector x = numbers(0.3), change = petsc::copy(x);
  const std::vector<double> value{0.1, 0.2, 7, 8, -0.4, 0.5};
  H.prescribe(set, value, x);
  H.apply_transpose(x, motion);
  for (const std::size_t i : {0, 1, 4, 5}) {
    CAPTURE(i);
    CHECK(std::abs(motion[i] - value[i]) < 1e-15);
  }
  check(VecAYPX(change, -1, x));
  CHECK(petsc::ReadArray(change)[3] == 0); // clamped
  // The smallest change is one by forces of these rows.
  H.multipliers(set, change, found);
  H.apply(-1, found, change);
  PetscReal rest = 0;
  check(VecNorm(change, NORM_INFINITY, &rest));
  CHECK(rest < 1e-15);
}

TEST_CASE("shared dofs belong to no cluster, and enter motions, forces and changes all the same",
          "[contact]") {
  const auto row = [](PetscInt node, double x,
                      double y) { // of a node and of the virtual node with dofs 4 and 5
    return ConstraintRows::Group{
        .entries = {
            {2 * node, x, false}, {2 * node + 1, y, false}, {4, -x, false, true}, {5, -y, false, true}}};
  };
  const ConstraintRows H(MPI_COMM_SELF, {row(1, 0.6, 0.8), row(0, 0, 1)}, 0, 6);
  REQUIRE(H.clusters().size() == 2);
  CHECK((H.share() && !H.dependent()));
  CHECK(H.dofs() == std::vector<PetscInt>{2, 3, 0, 1, 4, 5});
  petsc::Vector x;
  check(VecCreateSeq(PETSC_COMM_SELF, 6, x.put()));
  const petsc::Vector f = petsc::zero_like(x);
  {
    const petsc::WriteArray values(x);
    for (std::size_t i = 0; i < 6; ++i)
      values[i] = std::sin(1.0 + static_cast<double>(i));
  }
  const petsc::Vector before = petsc::copy(x);
  const std::vector<double> value{0.1, -0.3}, lambda{2, -0.5};
  std::vector<double> found(2);
  H.prescribe(contact::ActiveSet{0, 1}, value, x);
  H.apply_transpose(x, found);
  CHECK(std::abs(found[0] - value[0]) + std::abs(found[1] - value[1]) < 1e-15);
  CHECK((petsc::ReadArray(x)[4] == petsc::ReadArray(before)[4] &&
         petsc::ReadArray(x)[5] == petsc::ReadArray(before)[5]));
  H.apply(1, lambda, f);
  const petsc::ReadArray forces(f);
  CHECK((forces[4] == -(2 * 0.6) && forces[5] == -(2 * 0.8) + 0.5)); // opposite ones on the virtual node
  H.multipliers(contact::ActiveSet{0, 1}, f, found);
  CHECK(std::abs(found[0] - lambda[0]) + std::abs(found[1] - lambda[1]) < 1e-15);
  const petsc::Vector ones = petsc::zero_like(x);
  check(VecSet(ones, 1));
  const std::vector<double> squares = H.weighted_squares(ones);
  CHECK(std::abs(squares[0] - 1) + std::abs(squares[1] - 1) < 1e-15);
}

TEST_CASE("clamped dofs take their values from the decoupled system", "[contact]") {
  const ConstraintRows H(MPI_COMM_SELF, mixed, 0, dofs);
  const petsc::Vector r = numbers(0.2), d = numbers(4), y = petsc::zero_like(r);
  H.set_clamped(d, r, y);
  const petsc::ReadArray values(y), right(r), diagonal(d);
  for (std::size_t i = 0; i < values.size(); ++i)
    CHECK(values[i] == (i == 3 ? right[3] / diagonal[3] : 0));
}

TEST_CASE("rows with other coefficients keep their dofs and clamps", "[contact]") {
  const ConstraintRows H(MPI_COMM_SELF, mixed, 0, dofs);
  std::vector<double> other;
  for (int i = 0; i < 14; ++i)
    other.push_back(i + 1);
  const ConstraintRows changed = H.with(other);
  CHECK((changed.motion(0)[1] == 2 && changed.force(0)[1] == 0 && changed.force(5)[2] == 14));
  CHECK(changed.dofs() == H.dofs());
}

TEST_CASE("a basis of rows finds shortest motions and forces", "[contact]") {
  // The same as one node of space, and among more dofs.
  const std::size_t width = GENERATE(std::size_t(3), std::size_t(5));
  CAPTURE(width);
  std::vector<std::vector<double>> rows{{0, 0, 1}, {0, 0.6, 0.8}, {0, 1, 0}, {1, 1e-9, 0}};
  for (std::vector<double>& row : rows)
    row.resize(width);
  const ConstraintRows H = dense_rows(rows);
  contact::RowBasis basis(H);
  CHECK(basis.add(0));
  CHECK(basis.add(1));
  CHECK_FALSE(basis.add(2)); // in the plane of the first two
  CHECK(basis.add(3));
  CHECK_FALSE(basis.add(0));
  CHECK((basis.size() == 3 && basis.member(0) == 0 && basis.member(1) == 1 && basis.member(2) == 3));
  contact::RowBasis::Coordinates values = basis.coordinates();
  values[0] = 0.3, values[1] = -0.2, values[2] = 0.7;
  std::vector<double> x(width);
  basis.shortest(values);
  basis.add_to(x, values);
  CHECK(std::abs(x[2] - 0.3) < 1e-15);
  CHECK(std::abs(0.6 * x[1] + 0.8 * x[2] + 0.2) < 1e-15);
  CHECK(std::abs(x[0] + 1e-9 * x[1] - 0.7) < 1e-15);
  // 2 a − b + 3 d.
  std::vector<double> sum{3, -0.6 + 3e-9, 2 - 0.8};
  sum.resize(width);
  contact::RowBasis::Coordinates parts = basis.coordinates();
  for (std::size_t k = 0; k < 3; ++k)
    parts[k] = basis.along(k, sum);
  basis.combine(parts);
  CHECK(std::abs(parts[0] - 2) + std::abs(parts[1] + 1) + std::abs(parts[2] - 3) < 1e-14);
  basis.coefficients(2, parts); // (0, 1, 0) = (b − 0.8 a)/0.6
  CHECK(std::abs(parts[0] + 4.0 / 3) + std::abs(parts[1] - 5.0 / 3) + std::abs(parts[2]) < 1e-14);
  basis.replace(1, 2);
  CHECK((basis.size() == 3 && basis.member(1) == 2 && basis.member(2) == 3));
  CHECK_FALSE(basis.add(1));
}

TEST_CASE("rows whose dofs are on several ranks are one cluster", "[contact]") {
  // Each rank has a node of the body, the last one also a rigid body that all rows reach.
  const int size = ranks(MPI_COMM_WORLD), me = rank(MPI_COMM_WORLD);
  const PetscInt n = 2 * size + 2, own = me + 1 == size ? 4 : 2;
  Rows rows;
  for (PetscInt i = 0; i < size; ++i)
    rows.push_back({{{2 * i, std::cos(1.0 * i), false},
                     {2 * i + 1, std::sin(1.0 * i), i == 1},
                     {n - 2, -std::cos(1.0 * i), false},
                     {n - 1, -std::sin(1.0 * i), false}}});
  const ConstraintRows H(MPI_COMM_WORLD, rows, 2 * me, 2 * me + own), alone(MPI_COMM_SELF, rows, 0, n);
  REQUIRE(H.clusters().size() == 1);
  CHECK(H.clusters()[0].here == (size == 1));
  petsc::Vector x, y;
  check(VecCreateMPI(MPI_COMM_WORLD, own, n, x.put()));
  check(VecCreateSeq(PETSC_COMM_SELF, n, y.put()));
  const auto set = [&] {
    const petsc::WriteArray a(x), b(y);
    for (std::size_t i = 0; i < b.size(); ++i)
      b[i] = std::sin(1 + 1.7 * static_cast<double>(i));
    for (std::size_t i = 0; i < a.size(); ++i)
      a[i] = b[i + static_cast<std::size_t>(2 * me)];
  };
  const auto same = [&] {
    const petsc::ReadArray a(x), b(y);
    for (std::size_t i = 0; i < a.size(); ++i)
      CHECK(std::abs(a[i] - b[i + static_cast<std::size_t>(2 * me)]) < 1e-14);
  };
  std::vector<double> of_all(rows.size()), of_one(rows.size());
  const auto same_rows = [&] {
    for (std::size_t i = 0; i < rows.size(); ++i)
      CHECK(std::abs(of_all[i] - of_one[i]) < 1e-14);
  };
  set();
  H.apply_transpose(x, of_all);
  alone.apply_transpose(y, of_one);
  same_rows();
  H.apply(2, of_all, x);
  alone.apply(2, of_all, y);
  same();
  contact::ActiveSet active(rows.size());
  std::iota(active.begin(), active.end(), 0);
  set();
  H.multipliers(active, x, of_all);
  alone.multipliers(active, y, of_one);
  same_rows();
  CHECK(std::abs(of_all[0]) > 1e-3);
  std::vector<double> value(rows.size(), 0.3);
  H.prescribe(active, value, x);
  alone.prescribe(active, value, y);
  same();
  H.apply_transpose(x, of_all);
  for (const double moved : of_all)
    CHECK(std::abs(moved - 0.3) < 1e-14);
}
