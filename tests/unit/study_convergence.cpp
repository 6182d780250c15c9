// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/convergence.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <cmath>
#include <functional>

using namespace signorini::accuracy;
using Catch::Matchers::WithinAbs, Catch::Matchers::WithinRel;

namespace {

constexpr double exact_number = 1;

/// A chain of numbers and what it is made of.
class Numbers {
public:
  Numbers(std::vector<double> widths, const std::function<double(double)>& x) : widths_(std::move(widths)) {
    for (const double h : widths_)
      values_.push_back(x(h));
  }
  Numbers(const Numbers&) = delete;
  Numbers& operator=(const Numbers&) = delete;

  [[nodiscard]] Chain chain() const {
    Chain all;
    for (std::size_t i = 0; i < values_.size(); ++i)
      all.push_back({widths_[i], {&values_[i], 1}});
    return all;
  }
  [[nodiscard]] double error() const { return std::abs(values_.back() - exact_number); }

private:
  std::vector<double> widths_, values_;
};

std::function<double(double)> power(double factor, double p) {
  return [=](double h) { return exact_number + factor * std::pow(h, p); };
}

const std::vector<double> halved{1, 0.5, 0.25, 0.125}, uneven{1, 0.5, 0.3, 0.1};
const std::span<const double> known(&exact_number, 1);

} // namespace

TEST_CASE("the order of a power is found however widths are refined", "[study]") {
  constexpr double digits = 1e-9; // differences of numbers near one, the least of them 1e-3 of that
  for (const std::vector<double>& widths : {halved, uneven})
    for (const double p : {0.5, 1.0, 1.7, 2.0}) {
      CAPTURE(p);
      const Numbers numbers(widths, power(-0.3, p));
      for (const std::optional<Order>& order :
           {observed_order(numbers.chain(), {2, 0}), observed_order(numbers.chain(), known, {2, 0})}) {
        REQUIRE(order);
        CHECK_THAT(order->slope, WithinAbs(p, digits));
        CHECK_THAT(order->least, WithinAbs(p, digits));
        CHECK_THAT(order->largest, WithinAbs(p, digits));
        CHECK(order->asymptotic);
      }
    }
}

TEST_CASE("what does not fall as the method's errors is not in the asymptotic range", "[study]") {
  const auto in_range = [](const std::function<double(double)>& x, double limit) {
    const Numbers numbers(halved, x);
    return observed_order(numbers.chain(), {limit, 0})->asymptotic;
  };
  CHECK(in_range(power(1, 0.3), 2));
  CHECK_FALSE(in_range(power(1, 0.2), 2));
  CHECK_FALSE(in_range(power(1, -0.1), 2)); // grows
  CHECK(in_range(power(1, 2.45), 2));
  CHECK_FALSE(in_range(power(1, 2.55), 2));
  CHECK(in_range(power(1, 2.55), 4));
  CHECK_FALSE(in_range(power(1, 7.5), 4));
  // Differences of either sign, and the zero that an error passes through.
  CHECK_FALSE(in_range([](double h) { return h == 0.25 ? 1.1 : 1 + h; }, 2));
  CHECK_FALSE(in_range([](double h) { return 1 + h * (h - 0.2); }, 2));
  // Too coarse at first: what it says is of the others.
  const Numbers begun(halved, [](double h) { return h == 1 ? 0.7 : 1 + h; });
  const Order order = *observed_order(begun.chain(), {2, 0});
  CHECK(order.asymptotic);
  CHECK_THAT(order.least, WithinAbs(1, 1e-12));
  CHECK_THAT(order.largest, WithinAbs(1, 1e-12));
  // Of fields directions count: these turn by a right angle and more.
  const std::vector<std::vector<double>> turning{{1, 0}, {0.5, 0}, {0.5, 0.25}},
      straight{{1, 1}, {0.5, 0.5}, {0.25, 0.25}};
  const auto fields = [](const std::vector<std::vector<double>>& of) {
    return Chain{{1, of[0]}, {0.5, of[1]}, {0.25, of[2]}};
  };
  CHECK_FALSE(observed_order(fields(turning), {2, 0})->asymptotic);
  CHECK(observed_order(fields(straight), {2, 0})->asymptotic);
}

TEST_CASE("differences of rounding, and too few, give no order", "[study]") {
  const Numbers two({1, 0.5}, power(1, 1)),
      settled(halved, [](double h) { return h == 1 ? 2.0 : 1 + 1e-12 * h; });
  CHECK_FALSE(observed_order(two.chain(), {2, 0}));
  CHECK(observed_order(two.chain(), known, {2, 0}));
  CHECK_FALSE(observed_order(settled.chain(), {2, 1e-9}));
  CHECK_FALSE(observed_order(settled.chain(), known, {2, 1e-9}));
}

TEST_CASE("an error bar is twice the error of a power, and else three times the spread", "[study]") {
  for (const std::vector<double>& widths : {halved, uneven})
    for (const double p : {0.5, 1.0, 2.0}) {
      CAPTURE(p);
      const Numbers numbers(widths, power(-0.3, p));
      CHECK_THAT(*error_bar(numbers.chain(), {2, 0}), WithinRel(2 * numbers.error(), 1e-7));
    }
  // An order above the method's, by less than its scatter, is taken for the method's: a larger bar.
  const Numbers above({4, 2, 1}, power(1, 2.4));
  CHECK_THAT(*error_bar(above.chain(), {2, 0}), WithinRel(2 * (std::pow(2, 2.4) - 1) / 3, 1e-12));
  const Numbers jumps(halved, [](double h) { return h == 0.25 ? 1.2 : h == 0.125 ? 0.9 : 1.0; });
  CHECK_THAT(*error_bar(jumps.chain(), {2, 0}), WithinRel(3 * 0.3, 1e-12));
  const Numbers two({1, 0.5}, power(1, 1)), one({1}, power(1, 1));
  CHECK_THAT(*error_bar(two.chain(), {2, 0}), WithinRel(3 * 0.5, 1e-12));
  CHECK_FALSE(error_bar(one.chain(), {2, 0}));
}

TEST_CASE("the error bar holds where a second power and a scatter are mixed into the first", "[study]") {
  // The next power at up to half the size of the first, of either sign, and a scatter of a twentieth.
  std::uint64_t state = 1;
  const auto uniform = [&state] { // in [−1, 1]; the generator of Knuth's MMIX
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11) / static_cast<double>(1ULL << 52) - 1;
  };
  int holds = 0;
  constexpr int cases = 2000;
  for (int i = 0; i < cases; ++i) {
    const double p = 1.25 + 0.75 * uniform(), q = p + 1, second = 0.5 * uniform();
    const Numbers numbers({1, 0.5, 0.25}, [&](double h) {
      return exact_number + std::pow(h, p) * (1 + 0.05 * uniform()) + second * std::pow(h, q);
    });
    holds += numbers.error() <= *error_bar(numbers.chain(), {2, 0});
  }
  INFO("the bar held in " << holds << " of " << cases);
  CHECK(holds >= 0.95 * cases); // what the grid convergence index is meant for
}
