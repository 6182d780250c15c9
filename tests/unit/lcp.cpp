// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/lcp/goldfarb_idnani.h"
#include "contact/lcp/primal_dual.h"
#include "contact/row_basis.h"
#include <array>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

using namespace signorini;
using Point = std::array<double, 3>;

TEST_CASE("the dual active-set method solves singular problems or tells that they have no solution",
          "[contact]") {
  // Rows in the plane: directions round the circle, of which any three depend on each other.
  constexpr int m = 7;
  std::vector<double> N, S(m * m), lambda(m);
  for (int i = 0; i < m; ++i)
    for (const double n : {std::cos(0.9 * i), std::sin(0.9 * i)})
      N.push_back(n);
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < m; ++j)
      S[static_cast<std::size_t>(m * i + j)] = N[2 * i] * N[2 * j] + N[2 * i + 1] * N[2 * j + 1];
  std::vector<contact::ConstraintRows::Group> entries;
  for (std::size_t i = 0; i < m; ++i)
    entries.push_back({{{0, N[2 * i], false}, {1, N[2 * i + 1], false}}});
  const contact::ConstraintRows rows(MPI_COMM_SELF, entries, 0, 2);
  REQUIRE(rows.dependent());
  const auto columns = [&](int i) { return std::span(S).subspan(static_cast<std::size_t>(m * i), m); };
  const auto depends = [&](const contact::ActiveSet& set, int i) {
    contact::RowBasis basis(rows);
    for (int j : set)
      basis.add(j);
    return !basis.add(i);
  };
  contact::GoldfarbIdnaniWork work(m);
  contact::ActiveSet set;
  int pairs = 0;
  for (int which = 0; which < 50; ++which) {
    // Half-planes n·x ≤ 1 move by a shift: the closest point to the origin of their polygon.
    const double a = 0.3 * which, r = 0.1 * which;
    std::vector<double> gap(m);
    for (int i = 0; i < m; ++i)
      gap[static_cast<std::size_t>(i)] = 1 - r * (N[2 * i] * std::cos(a) + N[2 * i + 1] * std::sin(a));
    int steps = 0;
    REQUIRE(contact::goldfarb_idnani(columns, gap, 1e-14, depends, set, lambda, steps, work));
    CHECK(set.size() <= 2);
    pairs += set.size() == 2;
    for (std::size_t i = 0; i < m; ++i) {
      double g = gap[i];
      for (std::size_t j = 0; j < m; ++j)
        g += S[m * i + j] * lambda[j];
      CHECK(g > -1e-13);
      CHECK(lambda[i] >= 0);
      CHECK(std::abs(lambda[i] * g) < 1e-12);
      CHECK((lambda[i] > 0) == std::ranges::binary_search(set, static_cast<int>(i)));
    }
  }
  CHECK(pairs > 5);
  std::vector<double> empty(m, -0.1); // n·x ≤ −0.1 all round
  int steps = 0;
  CHECK_FALSE(contact::goldfarb_idnani(columns, empty, 1e-14, depends, set, lambda, steps, work));
}

TEST_CASE("of parallel constraints that close without forces the first is taken", "[contact]") {
  const contact::ConstraintRows rows(MPI_COMM_SELF,
                                     {{.entries = {{0, 1, false}, {1, 2, false}}},
                                      {.entries = {{0, 2, false}, {1, 4, false}}},
                                      {.entries = {{0, 3, false}, {1, 6, false}}}},
                                     0, 2);
  REQUIRE(rows.dependent());
  const std::vector<double> gap{-1, -2, -3};
  contact::ActiveSet next;
  contact::next_set(rows, {}, std::vector<double>{0, 0, 0}, gap, next);
  CHECK(next == contact::ActiveSet{0});
  contact::next_set(rows, {1}, std::vector<double>{0, 5, 0}, gap, next); // the ratio test
  CHECK(next == contact::ActiveSet{0});
}

TEST_CASE("the dual active-set method solves regular problems with many constraints closed", "[contact]") {
  // S = N Nᵀ of m directions in more dimensions, with gaps of both signs.
  constexpr std::size_t m = 9, n = 11;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto depends = [](const contact::ActiveSet&, int) { return false; };
  contact::GoldfarbIdnaniWork work(m);
  std::size_t most = 0;
  int left = 0; // constraints that were in the set on the way, but not at the end
  for (int which = 0; which < 100; ++which) {
    std::vector<double> N(m * n), S(m * m), gap0(m), lambda(m);
    for (double& x : N)
      x = 0.5 + normal(random); // to the same side, so that one constraint makes others superfluous
    for (std::size_t i = 0; i < m; ++i)
      for (std::size_t j = 0; j < m; ++j)
        S[i * m + j] = std::inner_product(&N[i * n], &N[i * n] + n, &N[j * n], 0.0);
    const auto columns = [&](int i) { return std::span(S).subspan(m * static_cast<std::size_t>(i), m); };
    for (double& g : gap0)
      g = normal(random) - 0.5;
    contact::ActiveSet set;
    int steps = 0;
    REQUIRE(contact::goldfarb_idnani(columns, gap0, 1e-13, depends, set, lambda, steps, work));
    most = std::max(most, set.size());
    left += steps - static_cast<int>(set.size());
    for (std::size_t i = 0; i < m; ++i) {
      const double g = std::inner_product(&S[i * m], &S[i * m] + m, lambda.begin(), gap0[i]);
      const bool closed = std::ranges::binary_search(set, static_cast<int>(i));
      CHECK(g > -1e-12);
      CHECK((lambda[i] > 0) == closed);
      if (closed)
        CHECK(std::abs(g) < 1e-11);
    }
  }
  CHECK(most > 4);
  CHECK(left > 0);
}
