// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.h"
#include "base/petsc.h"
#include "linalg/dense.h"
#include "linalg/simplex_qp.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <random>
#include <vector>

using namespace signorini;

namespace {

std::vector<double> products(const std::vector<std::vector<double>>& g) {
  std::vector<double> all;
  for (const auto& a : g)
    for (const auto& b : g) {
      double sum = 0;
      for (std::size_t c = 0; c < a.size(); ++c)
        sum += a[c] * b[c];
      all.push_back(sum);
    }
  return all;
}

std::vector<double> combined(const std::vector<std::vector<double>>& g, const std::vector<double>& weights) {
  std::vector<double> x(g.front().size());
  for (std::size_t i = 0; i < g.size(); ++i)
    for (std::size_t c = 0; c < x.size(); ++c)
      x[c] += weights[i] * g[i][c];
  return x;
}

std::vector<double> shortest(const std::vector<std::vector<double>>& g) {
  return simplex_qp(products(g), std::vector<double>(g.size())).value();
}

/// How far weights are from the conditions of the best (Karush, Kuhn, Tucker), of the largest term: g_i·x +
/// e_i is the same wherever w_i > 0 and no less elsewhere.
double unmet(const std::vector<std::vector<double>>& g, const std::vector<double>& prices,
             const std::vector<double>& weights) {
  const auto x = combined(g, weights);
  std::vector<double> slopes;
  double mean = 0, largest = 0, sum = 0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    double slope = prices[i], square = 0;
    for (std::size_t c = 0; c < x.size(); ++c) {
      slope += x[c] * g[i][c];
      square += g[i][c] * g[i][c];
    }
    slopes.push_back(slope);
    mean += weights[i] * slope;
    sum += weights[i];
    largest = std::max({largest, square, std::abs(prices[i])});
    REQUIRE(weights[i] >= 0);
  }
  REQUIRE(std::abs(sum - 1) < 1e-12);
  double most = 0;
  for (std::size_t i = 0; i < g.size(); ++i)
    most = std::max({most, mean - slopes[i], weights[i] * (slopes[i] - mean)});
  return most / largest;
}

/// n vectors of which some are the same, some opposite, some depend on others, and lengths differ by orders
/// of magnitude.
std::vector<std::vector<double>> awkward(std::mt19937& random, std::size_t n, std::size_t dimensions) {
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> g;
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<double> v(dimensions);
    const double length = std::pow(10, -static_cast<double>(random() % 4));
    for (double& c : v)
      c = length * normal(random);
    if (i > 0 && i % 3 == 0)
      v = g[random() % i];
    if (i > 1 && i % 5 == 0)
      for (std::size_t c = 0; c < dimensions; ++c)
        v[c] = g[i - 1][c] / 2 + g[i - 2][c] / 2;
    g.push_back(std::move(v));
  }
  return g;
}

/// Relative error of sums of 50 products and of solves with as many unknowns, with room for constants.
constexpr double rounding = 1e-13;

} // namespace

TEST_CASE("There is no best combination of no vectors, and none of what is not finite", "[base]") {
  CHECK_FALSE(simplex_qp({}, {}));
  const std::vector<double> none{0, 0};
  CHECK_FALSE(simplex_qp(std::vector<double>{1, 0, 0, std::nan("")}, none));
}

TEST_CASE("Awkward vectors have a best combination too", "[base]") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform;
  for (const std::size_t n : {2, 5, 15, 40})
    for (const std::size_t dimensions : {1, 3, 10, 50})
      for (const bool priced : {false, true})
        for (int run = 0; run < 5; ++run) {
          INFO(n << " vectors in " << dimensions << " dimensions" << (priced ? ", with prices" : "")
                 << ", run " << run);
          const auto g = awkward(random, n, dimensions);
          std::vector<double> prices(n);
          if (priced)
            for (double& e : prices)
              e = 0.1 * uniform(random);
          CHECK(unmet(g, prices, simplex_qp(products(g), prices).value()) < rounding);
        }
}

TEST_CASE("Vectors whose products span forty orders of magnitude have a best combination", "[base]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform;
  std::normal_distribution<double> normal;
  for (const std::size_t n : {3, 12, 41})
    for (const std::size_t dimensions : {1, 3, 10, 50})
      for (int run = 0; run < 10; ++run) {
        INFO(n << " vectors in " << dimensions << " dimensions, run " << run);
        std::vector<std::vector<double>> g(n);
        std::vector<double> prices(n);
        for (std::size_t i = 0; i < n; ++i) {
          const double length = std::pow(10, 10 - 20 * uniform(random));
          for (std::size_t c = 0; c < dimensions; ++c)
            g[i].push_back(length * normal(random));
          if (run % 2)
            prices[i] = uniform(random) * std::pow(10, 20 - 40 * uniform(random));
        }
        CHECK(unmet(g, prices, simplex_qp(products(g), prices).value()) < rounding);
      }
}

TEST_CASE("Ties do not keep the best combination from being found", "[base]") {
  std::mt19937 random(6);
  for (const std::size_t n : {4, 15, 41})
    for (const std::size_t dimensions : {1, 2, 4, 12})
      for (int run = 0; run < 20; ++run) {
        INFO(n << " vectors in " << dimensions << " dimensions, run " << run);
        // Points of a lattice: many are the same, on one line, or as near to the origin as others.
        std::vector<std::vector<double>> g(n);
        std::vector<double> prices(n);
        for (std::size_t i = 0; i < n; ++i) {
          for (std::size_t c = 0; c < dimensions; ++c)
            g[i].push_back(static_cast<double>(random() % 5) - (run % 3 ? 2 : 0));
          prices[i] = run % 2 ? static_cast<double>(random() % 3) : 0;
        }
        CHECK(unmet(g, prices, simplex_qp(products(g), prices).value()) < rounding);
      }
}

TEST_CASE("The best combination of vectors that are the same, on a line or around zero", "[base]") {
  const auto best = [](const std::vector<std::vector<double>>& g, const std::vector<double>& prices) {
    return simplex_qp(products(g), prices).value();
  };
  // Of twins the cheapest counts, also among prices that are large, and where lengths are zero.
  CHECK(best({{1, 2}, {1, 2}, {1, 2}}, {3, 1, 2}) == std::vector<double>{0, 1, 0});
  CHECK(best({{1, 2}, {1, 2}, {1, 2}}, {3e20, 2e20, 1e20}) == std::vector<double>{0, 0, 1});
  CHECK(best({{0}, {0}, {0}}, {3, 2, 1}) == std::vector<double>{0, 0, 1});
  CHECK(best({{0}, {1}, {0}}, {0, -2, -1}) == std::vector<double>{0, 1, 0});
  CHECK(unmet({{1, 2}, {1, 2}, {1, 2}}, {0, 0, 0}, shortest({{1, 2}, {1, 2}, {1, 2}})) < rounding);
  // Minimum at a vertex that is the last to be tried, with others on a line behind it.
  CHECK(shortest({{4, 0}, {3, 1}, {2, 2}, {1, 3}, {0.5, 0.5}}) == std::vector<double>{0, 0, 0, 0, 1});
  const auto line = combined({{-3, 1}, {-1, 1}, {1, 1}, {5, 1}, {9, 1}},
                             shortest({{-3, 1}, {-1, 1}, {1, 1}, {5, 1}, {9, 1}}));
  CHECK(std::abs(line[0]) < rounding);
  CHECK(std::abs(line[1] - 1) < rounding);
  // Zero in the interior of a simplex, once more with its centre and far from the first vertex.
  const double far = GENERATE(1.0, 1e3);
  CAPTURE(far);
  const std::vector<std::vector<double>> around{
      {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-far, -far, -far}, {0, 0, 0}};
  for (const std::size_t count : {4, 5}) {
    const std::vector<std::vector<double>> g(around.begin(), around.begin() + static_cast<long>(count));
    for (const double c : combined(g, shortest(g)))
      CHECK(std::abs(c) < rounding);
  }
}

TEST_CASE("A Cholesky factor stays accurate while columns come and go", "[base]") {
  constexpr std::size_t m = 40;
  constexpr double condition = 1e8;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> g(m, std::vector<double>(m));
  for (auto& v : g)
    for (std::size_t c = 0; c < m; ++c)
      v[c] = normal(random) * std::pow(condition, -static_cast<double>(c) / (2 * (m - 1)));
  const std::vector<double> K = products(g);
  UpdatedCholesky factor(m);
  std::vector<std::size_t> set;
  const auto column = [&](std::size_t j) {
    std::vector<double> entries;
    for (std::size_t i : set)
      entries.push_back(K[i * m + j]);
    return entries;
  };
  std::size_t removed = 0;
  for (int change = 0; change < 2000; ++change) {
    const std::size_t j = random() % m;
    if (const auto at = std::ranges::find(set, j); at == set.end()) {
      REQUIRE(factor.append(column(j), K[j * m + j]));
      set.push_back(j);
    } else {
      CHECK_FALSE(factor.append(column(j), K[j * m + j], rounding)); // depends on itself
      factor.remove(static_cast<std::size_t>(at - set.begin()));
      set.erase(at);
      ++removed;
    }
    REQUIRE(factor.size() == set.size());
    std::vector<double> b, x;
    for (std::size_t i = 0; i < set.size(); ++i)
      b.push_back(normal(random));
    factor.solve(x = b);
    // The residual of a backward stable solve is rounding of K's and x's sizes, whatever the condition.
    double off = 0, size = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
      double residual = b[i];
      for (std::size_t k = 0; k < set.size(); ++k)
        residual -= K[set[i] * m + set[k]] * x[k];
      off = std::max(off, std::abs(residual));
      size = std::max(size, std::abs(x[i]));
    }
    CHECK(off <= rounding * K[0] * size);
  }
  CHECK(removed > 500);
}

TEST_CASE("The best combination does not depend on units", "[base]") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform;
  for (int run = 0; run < 10; ++run) {
    const auto g = awkward(random, 12, 5);
    std::vector<double> prices, G = products(g);
    for (std::size_t i = 0; i < g.size(); ++i)
      prices.push_back(run % 2 ? uniform(random) : 0);
    const auto weights = simplex_qp(G, prices).value();
    for (const int exponent : {-60, 60}) {
      CAPTURE(exponent);
      std::vector<double> other_G = G, other_prices = prices;
      for (double& x : other_G)
        x = std::ldexp(x, exponent);
      for (double& x : other_prices)
        x = std::ldexp(x, exponent);
      CHECK(simplex_qp(other_G, other_prices) == weights);
    }
  }
}

TEST_CASE("The shortest combination of known vectors", "[base]") {
  const auto x = combined({{1, 1}, {1, -3}}, shortest({{1, 1}, {1, -3}}));
  CHECK(std::abs(x[0] - 1) < 1e-12);
  CHECK(std::abs(x[1]) < 1e-12);
  // Around zero, twice the same, and one that is of no use.
  const std::vector<std::vector<double>> around{{3, 0}, {-1, 2}, {-1, 2}, {-1, -2}, {50, 1}};
  for (const double c : combined(around, shortest(around)))
    CHECK(std::abs(c) < rounding);
  CHECK(shortest({{2}}) == std::vector<double>{1.0});
}

TEST_CASE("The shortest combination is no longer along any of the vectors, whatever its length", "[base]") {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const double length : {1.0, 1e-2, 1e-4})
    for (int run = 0; run < 20; ++run) {
      CAPTURE(length, run);
      // n vectors that differ in some dimensions by 1 and share a short one in another.
      std::vector<std::vector<double>> g;
      for (int i = 0; i < 12; ++i) {
        g.push_back({});
        for (int c = 0; c < 5; ++c)
          g.back().push_back(1e-4 * normal(random));
        g.back().push_back(1e-4 * length);
      }
      const auto weights = shortest(g);
      double sum = 0, xx = 0;
      const auto x = combined(g, weights);
      for (const double c : x)
        xx += c * c;
      for (const double w : weights) {
        CHECK(w >= 0);
        sum += w;
      }
      CHECK(std::abs(sum - 1) < 1e-14);
      for (const auto& gi : g) {
        double product = 0;
        for (std::size_t c = 0; c < x.size(); ++c)
          product += x[c] * gi[c];
        CHECK(product >= xx - rounding * 1e-7);
      }
    }
}

TEST_CASE("The best combination of vectors with prices satisfies its conditions", "[base]") {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  int cheaper = 0;
  for (int run = 0; run < 20; ++run) {
    std::vector<std::vector<double>> g(9);
    std::vector<double> prices;
    for (auto& gi : g) {
      for (int c = 0; c < 4; ++c)
        gi.push_back(normal(random));
      prices.push_back(std::abs(normal(random)));
    }
    const auto weights = simplex_qp(products(g), prices).value();
    cheaper += weights != shortest(g);
    const auto x = combined(g, weights);
    // g_i·x + e_i is the same wherever w_i > 0, and no less elsewhere.
    std::vector<double> slopes;
    double mean = 0;
    for (std::size_t i = 0; i < g.size(); ++i) {
      double slope = prices[i];
      for (std::size_t c = 0; c < x.size(); ++c)
        slope += x[c] * g[i][c];
      slopes.push_back(slope);
      mean += weights[i] * slope;
    }
    for (std::size_t i = 0; i < g.size(); ++i) {
      CHECK(slopes[i] > mean - 1e-9);
      if (weights[i] > 1e-6)
        CHECK(slopes[i] < mean + 1e-9);
    }
  }
  CHECK(cheaper > 10);
}

TEST_CASE("A sum of vectors does not depend on what it overwrites", "[base]") {
  const auto vector = [](double a, double b) {
    petsc::Vector x;
    petsc::check(VecCreateSeq(PETSC_COMM_SELF, 2, x.put()));
    petsc::check(VecSetValue(x, 0, a, INSERT_VALUES));
    petsc::check(VecSetValue(x, 1, b, INSERT_VALUES));
    petsc::check(VecAssemblyBegin(x));
    petsc::check(VecAssemblyEnd(x));
    return x;
  };
  const petsc::Vector x = vector(3, -5), y = vector(0.25, 7);
  for (const double a : {-1.0, 0.0, 0.5, 1.0})
    for (const double b : {-1.0, 0.0, 1.0, 2.0}) {
      CAPTURE(a, b);
      const petsc::Vector out = vector(std::nan(""), INFINITY);
      petsc::combine(out, a, x, b, y);
      const petsc::ReadArray found(out);
      CHECK(found[0] == a * 3 + b * 0.25);
      CHECK(found[1] == a * -5 + b * 7);
    }
}
