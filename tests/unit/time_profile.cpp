// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/time_profile.h"
#include "base/error.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <fmt/format.h>
#include <numbers>
#include <random>

using namespace signorini;

namespace {

scene::Field field(const std::string& text) { return {{text}, "load.body", true}; }

/// Values of an expression at random points of random boxes lie in its enclosure.
void lies_within(const std::string& text, std::mt19937& random) {
  CAPTURE(text);
  const scene::Field f = field(text);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 50; ++trial) {
    scene::Box box;
    for (scene::Interval& side : box) {
      const double a = 3 * unit(random) - 1, b = a + std::pow(unit(random), 4);
      side = scene::Interval(a, b);
    }
    const scene::Interval range = f.enclose(0, box);
    for (int point = 0; point < 20; ++point) {
      std::array<double, 4> x{};
      for (std::size_t c = 0; c < 4; ++c)
        x[c] = box[c].lower() + unit(random) * (box[c].upper() - box[c].lower());
      double value = 0;
      try {
        value = f.value(0, x.data(), x[3]);
      } catch (const UserError&) { // such as the root of a negative number
        continue;
      }
      const double rounding = 1e-12 * (1 + std::abs(value));
      CHECK(range.lower() <= value + rounding);
      CHECK(range.upper() >= value - rounding);
    }
  }
}

double mean(const std::string& text, double from, double to, double end) {
  const std::vector<double> points{0.3, 0.4, 0};
  const fem::TimeProfile profile(MPI_COMM_SELF, field(text), points, end);
  CHECK(profile.unresolved() == 0);
  double value = 0;
  profile.mean(from, to, std::span(&value, 1));
  return value;
}

} // namespace

TEST_CASE("an enclosure holds all values of an expression, and reads it as muParser does", "[scene]") {
  std::mt19937 random(7);
  for (const char* text : {"1.5e-3*t",
                           "-t^2",
                           "2^-t",
                           "2^-x^2",
                           "-2^2*t",
                           "t-1-2",
                           "8/t/2",
                           "t*-x",
                           "(t-x)^3",
                           "t^2.5",
                           "t^-1",
                           "sin(3*t+x)*cos(y)",
                           "tan(t)",
                           "exp(-((x-t)/0.1)^2)",
                           "sqrt(t)",
                           "log(t)+ln(t)+log2(t)+log10(t)",
                           "asin(t/3)+acos(x/3)+atan(z)",
                           "sinh(t)+cosh(x)+tanh(y)",
                           "asinh(t)+acosh(t+2)+atanh(x/3)",
                           "abs(t-x)",
                           "sign(t-x)+rint(4*t)",
                           "min(t,x,y)+max(t,z)",
                           "sum(t,x,y)+avg(x,z)",
                           "atan2(t,x)",
                           "t < 0.5 ? 1 : t > 1 ? x : -1",
                           "t > 0.2 && x < 1 || y >= 0.5",
                           "(t == 1) + (x != 2)",
                           "t <= x ? t : x",
                           "1 < t < 2",
                           "+t - -x",
                           "pi*t + e",
                           "t < 1 ? 2 : 3 + 4*t"})
    lies_within(text, random);
  CHECK_FALSE(scene::Enclosure("t $ 2").known());
}

TEST_CASE("numbers compared with t are knots", "[scene]") {
  using Knots = std::vector<double>;
  CHECK(scene::Enclosure("t < 0.25 ? 1 : 0").knots() == Knots{0.25});
  CHECK(scene::Enclosure("2*t - 1 > 0").knots() == Knots{0.5});
  CHECK(scene::Enclosure("abs(t/4 - 1) < x").knots() == Knots{4});
  CHECK(scene::Enclosure("max(t, 2) + min(-(t), 1 - 3*t)").knots() == Knots{2, 0.5});
  CHECK(scene::Enclosure("x < 0.5 ? t : t^2").knots().empty());
}

TEST_CASE("means over steps are exact, whatever passes within them", "[fem]") {
  const double end = 5;
  SECTION("polynomials, at any part of a panel") {
    for (const double length : {4.0, 1.0, 0.1, 1e-3}) {
      CAPTURE(length);
      const double a = 0.7, b = a + length;
      CHECK(std::abs(mean("t^3 - 2*t", a, b, end) /
                         ((std::pow(b, 4) - std::pow(a, 4)) / 4 - (b * b - a * a)) * length -
                     1) < 1e-12);
    }
  }
  SECTION("waves") {
    const double w = 40 * std::numbers::pi;
    for (const double length : {4.0, 0.33, 1e-3}) {
      CAPTURE(length);
      CHECK(std::abs(mean("sin(40*pi*t)", 0.6, 0.6 + length, end) -
                     (std::cos(w * 0.6) - std::cos(w * (0.6 + length))) / w / length) < 1e-9);
    }
  }
  SECTION("pulses that no sample would see, of an impulse of 1") {
    for (const double width : {1e-5, 1e-3, 0.1}) {
      const std::string at = "1.2345678", w = fmt::format("{}", width);
      const double impulse = std::sqrt(std::numbers::pi) * width;
      const std::vector<std::pair<std::string, double>> pulses{
          {"abs(t-" + at + ") < " + w + " ? 1/(2*" + w + ") : 0", 1},
          {"t > " + at + " && t < " + at + " + " + w + " ? 1/" + w + " : 0", 1},
          {"exp(-((t-" + at + ")/" + w + ")^2)", impulse},
          {"max(0, 1 - abs(t-" + at + ")/" + w + ")", width},
          {"(t-" + at + ")^2 < " + w + "^2 ? 1 : 0", 2 * width}};
      for (const auto& [text, expected] : pulses) {
        CAPTURE(text);
        CHECK(std::abs(mean(text, 0, end, end) * end / expected - 1) < 1e-8);
        CHECK(std::abs(mean(text, 0.5, 2, end) * 1.5 / expected - 1) < 1e-8);
      }
    }
  }
}

TEST_CASE("a pulse local in space is seen at whichever points it acts", "[fem]") {
  std::vector<double> points;
  constexpr int n = 4000;
  for (int i = 0; i < n; ++i)
    points.insert(points.end(), {std::fmod(0.618034 * i, 1.0), i / static_cast<double>(n), 0});
  const fem::TimeProfile profile(
      MPI_COMM_SELF, field("abs(t-2) < 1e-3 && (x-0.5)^2 + (y-0.5)^2 < 1e-3 ? 500 : 0"), points, 5);
  CHECK(profile.unresolved() == 0);
  std::vector<double> means(n);
  profile.mean(0, 5, means);
  int hit = 0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const bool within = std::pow(points[3 * i] - 0.5, 2) + std::pow(points[3 * i + 1] - 0.5, 2) < 1e-3;
    hit += within;
    CHECK(std::abs(5 * means[i] - within) < 1e-8);
  }
  REQUIRE(hit > 3);
  CHECK(profile.variation(1, 3) > 0.9);
  CHECK(profile.variation(3, 4) == 0);
}

TEST_CASE("a time series is integrated between its own times", "[fem]") {
  std::string text = "t,f\n";
  constexpr int n = 5000; // at 1 kHz, one value of which is not zero
  for (int i = 0; i <= n; ++i)
    text += fmt::format("{},{}\n", i * 1e-3, i == 1234 ? 7 : 0);
  const fem::TimeProfile profile(
      MPI_COMM_SELF,
      scene::Field({scene::Expression("series", scene::TimeSeries(text, "f"))}, "load.body", true), {}, 5);
  double value = 0;
  profile.mean(0, 5, std::span(&value, 1));
  CHECK(std::abs(5 * value - 7e-3) < 1e-15);
  profile.mean(1.2335, 1.234, std::span(&value, 1));
  CHECK(std::abs(value - 7 * 0.75) < 1e-9);
  CHECK(profile.variation(1, 1.5) > 1.9);
  CHECK(std::abs(profile.deviation(1, 1.5) - 7) < 1e-12);
  CHECK(profile.deviation(2, 3) == 0);
}

TEST_CASE("what cannot be integrated is said", "[fem]") {
  const std::vector<double> points{0, 0, 0};
  CHECK(fem::TimeProfile(MPI_COMM_SELF, field("sin(1e9*t)"), points, 5).unresolved() > 0.5);
  CHECK(fem::TimeProfile(MPI_COMM_SELF, field("exp(-t)"), points, 5).unresolved() == 0);
}
