#include "base/best_combination.h"
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
  return best_combination(products(g), std::vector<double>(g.size()));
}

} // namespace

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
    const auto weights = best_combination(products(g), prices);
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
