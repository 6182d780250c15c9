// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/impulse_record.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <numbers>

using namespace signorini::trajectory;

namespace {

constexpr double pi = std::numbers::pi, begin = 0.25; // of half a sine of one second, s

/// ∫ sin π(s − begin) ds until t.
double impulse(double t) { return (1 - std::cos(pi * std::clamp(t - begin, 0.0, 1.0))) / pi; }

/// A push of half a sine between rests, by its means over steps of two lengths in turn.
ImpulseRecord half_sine(double tau) {
  ImpulseRecord record;
  double t = 0;
  for (int k = 0; t < 2; ++k) {
    const double end = t + (k % 2 == 0 ? tau : tau / 2);
    record.add(end, (impulse(end) - impulse(t)) / (end - t));
    t = end;
  }
  return record;
}

} // namespace

TEST_CASE("the figures of half a sine of force are those of closed forms", "[forward]") {
  const double tau = GENERATE(2e-3, 1e-3);
  INFO("steps of " << tau);
  const ImpulseRecord record = half_sine(tau);
  CHECK(std::abs(record.total() - 2 / pi) < 1e-12);
  for (const double t : {0.1, 0.4, 0.75, 1.1, 1.9}) {
    CAPTURE(t);
    CHECK(std::abs(record.until(t) - impulse(t)) < pi * tau * tau); // linear within a step
  }
  CHECK(std::abs(record.mean(0.5, 0.9) - (impulse(0.9) - impulse(0.5)) / 0.4) < 10 * pi * tau * tau);
  const auto time_of = [](double part) { return begin + std::acos(1 - 2 * part) / pi; };
  const auto [from, to] = record.between(0.1, 0.7);
  CHECK(std::abs(from - time_of(0.1)) < 10 * tau * tau);
  CHECK(std::abs(to - time_of(0.7)) < 10 * tau * tau);
  CHECK(std::abs(record.duration() - (time_of(0.99) - time_of(0.01))) < 100 * tau * tau);
  for (const double window : {0.1, 0.4}) {
    CAPTURE(window);
    const ImpulseRecord::Mean most = record.largest_mean(window);
    CHECK(most.over == window);
    CHECK(std::abs(most.force - 2 / (pi * window) * std::sin(pi * window / 2)) < 10 * tau * tau / window);
    CHECK(std::abs(most.end - (begin + 0.5 + window / 2)) < 2 * tau);
  }
  // A window below two steps is as long as these.
  CHECK(std::abs(record.largest_mean(tau / 10).over - 1.5 * tau) < 1e-12);
  CHECK(record.peak(0.1).smooth);
}

TEST_CASE("a time without a force has two ends in a record", "[forward]") {
  ImpulseRecord record;
  for (int k = 1; k <= 100; ++k)
    record.add(k, k == 50 ? 3 : 0);
  CHECK(record.times().size() < 10);
  CHECK(record.total() == 3);
  CHECK(record.until(49) == 0);
  CHECK(record.until(49.5) == 1.5);
  CHECK(record.until(50) == 3);
  CHECK(record.until(200) == 3);
  ImpulseRecord none;
  none.add(1, 0);
  CHECK(none.between(0.1, 0.9) == std::pair(0.0, 0.0));
}
