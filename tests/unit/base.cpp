#include "base/error.h"
#include "linalg/simplex_qp.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
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

} // namespace

TEST_CASE("There is no best combination of no vectors, and none of what is not finite", "[base]") {
  CHECK_FALSE(simplex_qp({}, {}));
  const std::vector<double> none{0, 0};
  CHECK_FALSE(simplex_qp(std::vector<double>{1, 0, 0, std::nan("")}, none));
}

TEST_CASE("Awkward vectors have a best combination too", "[base]") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform;
  int all = 0, to_rounding = 0;
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
          const double off = unmet(g, prices, simplex_qp(products(g), prices).value());
          CHECK(off < 1e-4);
          ++all;
          to_rounding += off < 1e-10;
        }
  // Where the vectors in use keep depending on each other the weights stay TAO's, which are worse.
  CHECK(to_rounding >= 0.98 * all);
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
    CHECK(std::abs(c) < 1e-7);
  CHECK(shortest({{2}}) == std::vector<double>{1.0});
}

TEST_CASE("The shortest combination is no longer along any of the vectors, whatever its length", "[base]") {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const double length : {1.0, 1e-2, 1e-4})
    for (int run = 0; run < 20; ++run) {
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
        CHECK(product >= xx - 1e-7 * 1e-8);
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
