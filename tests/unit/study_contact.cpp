// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/contact_forces.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <cmath>
#include <functional>

using namespace signorini;
using Catch::Matchers::WithinAbs;
using contact::Status;

namespace {

using Gap = std::function<double(double t)>;

/// Contact of candidates with gaps g(t), strong where they are not positive, up to the last of `steps` steps.
std::vector<diagnostics::ContactTimes::Interval> intervals(const std::vector<Gap>& gaps, double tau,
                                                           int steps, std::vector<int> candidates = {}) {
  const auto m = static_cast<int>(gaps.size());
  if (candidates.empty())
    for (int i = 0; i < m; ++i)
      candidates.push_back(i);
  const step::TimeGrid grid(tau, steps);
  diagnostics::ContactTimes times(candidates);
  for (int k = 0; k <= steps; ++k) {
    contact::ContactState state(m);
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      const double gap = gaps[i](k * tau);
      state.gap[i] = std::max(gap, 0.0);
      if (k > 0 && gap <= 0) // no step has led to the first frame
        state.status[i] = Status::strong;
    }
    times.observe(grid.step(k), state);
  }
  return times.intervals();
}

/// Comes with a speed of 2, touches at `start`, and leaves with a speed of 3 at `end`.
Gap visit(double start, double end) {
  return [=](double t) { return t < start ? 2 * (start - t) : t > end ? 3 * (t - end) : 0; };
}

} // namespace

TEST_CASE("contact with a speed begins and ends at its times, wherever steps fall", "[study]") {
  constexpr double start = 0.5, end = 1.17;
  double worst = 0;
  for (const double tau : {0.1, 0.07, 0.033, 0.0101}) {
    CAPTURE(tau);
    const auto found = intervals({visit(start, end)}, tau, static_cast<int>(2 / tau));
    REQUIRE(found.size() == 1);
    CHECK_THAT(found[0].start, WithinAbs(start, 1e-12));
    CHECK_THAT(found[0].end, WithinAbs(end, 1e-12));
    // By whole steps it would be off.
    const double counted = tau * (std::floor(end / tau) - std::ceil(start / tau) + 1);
    worst = std::max(worst, std::abs(counted - (end - start)) / tau);
  }
  CHECK(worst > 0.3);
}

TEST_CASE("where the speed changes contact times are off by the square of the step", "[study]") {
  constexpr double start = 0.51, end = 0.77, speed = 2, acceleration = 8;
  const Gap gap = [](double t) {
    const double before = std::max(start - t, t - end);
    return before > 0 ? before * (speed + acceleration / 2 * before) : 0;
  };
  const double tau = GENERATE(0.05, 0.031, 0.02, 0.0077, 0.003);
  CAPTURE(tau);
  const auto found = intervals({gap}, tau, static_cast<int>(1 / tau));
  REQUIRE(found.size() == 1);
  // The chord through the two gaps is off by a/2 θ(1 + θ) τ² within the step at most, and falls with v.
  const double bound = acceleration * tau * tau / speed + 1e-12;
  CHECK(std::abs(found[0].start - start) < bound);
  CHECK(std::abs(found[0].end - end) < bound);
}

TEST_CASE("of several candidates the first to come and the last to go tell", "[study]") {
  const std::vector<Gap> gaps{visit(0.31, 0.6), visit(0.34, 0.83), visit(0.5, 0.7)};
  const double tau = GENERATE(0.1, 0.03);
  CAPTURE(tau);
  const auto found = intervals(gaps, tau, static_cast<int>(1.2 / tau));
  REQUIRE(found.size() == 1);
  CHECK_THAT(found[0].start, WithinAbs(0.31, 1e-12));
  CHECK_THAT(found[0].end, WithinAbs(0.83, 1e-12));
  const auto own = intervals(gaps, tau, static_cast<int>(1.2 / tau), {2});
  REQUIRE(own.size() == 1);
  CHECK_THAT(own[0].start, WithinAbs(0.5, 1e-12));
  CHECK_THAT(own[0].end, WithinAbs(0.7, 1e-12));
}

TEST_CASE("contact that is there from the first and until the last has no ends in between", "[study]") {
  const auto always = intervals({[](double) { return 0.0; }}, 0.1, 10);
  REQUIRE(always.size() == 1);
  CHECK_THAT(always[0].start, WithinAbs(0, 1e-15));
  CHECK_THAT(always[0].end, WithinAbs(1, 1e-15));
  CHECK(intervals({[](double) { return 1.0; }}, 0.1, 10).empty());
  CHECK(intervals({}, 0.1, 10).empty());
  // Gone in the last step: no gap after that, so half of it.
  const auto late = intervals({visit(0.25, 0.95)}, 0.1, 10);
  CHECK_THAT(late.at(0).end, WithinAbs(0.95, 1e-12));
  // There in the first step, from a distance: no gap before that.
  CHECK_THAT(intervals({visit(0.02, 0.55)}, 0.1, 10).at(0).start, WithinAbs(0.05, 1e-15));
}

TEST_CASE("chatter counts by its steps", "[study]") {
  // Open in every second step, by next to nothing.
  const Gap chatter = [](double t) { return std::lround(t / 0.1) % 2 == 1 ? 0.0 : 1e-6; };
  const auto found = intervals({chatter}, 0.1, 10);
  REQUIRE(found.size() == 5);
  double time = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK((i == 0 || found[i].start >= found[i - 1].end - 1e-12));
    time += found[i].end - found[i].start;
  }
  CHECK_THAT(time, WithinAbs(5 * 0.1, 1e-12));
}
