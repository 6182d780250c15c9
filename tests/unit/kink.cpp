// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/search_log.h"
#include "fixtures.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <iterator>
#include <set>

using namespace signorini;

TEST_CASE("contact is weak where it is closed at some points of a certificate and open at others",
          "[control]") {
  const test::Ready ready("tests/data/block.toml");
  problem::ControlProblem problem(ready.problem, test::silent());
  using Closed = std::set<std::pair<int, int>>; // step, candidate
  std::vector<Closed> each;
  optimize::Certificate<control::Variables> certificate{0.25, 0.5, {}, {0.5, 0.25, 0.25}};
  for (const char* push : {"0", "-1", "0.5"}) {
    certificate.points.push_back(
        optimize::share<control::Variables>(problem.controls.interpolate({"0", push}, "test")));
    problem.reduced.simulate(*certificate.points.back());
    const auto& contact = problem.reduced.trial_trajectory().contact();
    Closed& closed = each.emplace_back();
    for (std::size_t k = 0; k < contact.size(); ++k)
      for (const int i : contact[k].active)
        closed.emplace(static_cast<int>(k), i);
  }
  Closed any, all = each.front(), weak;
  for (const Closed& one : each) {
    any.insert(one.begin(), one.end());
    Closed both;
    std::ranges::set_intersection(all, one, std::inserter(both, both.end()));
    all = std::move(both);
  }
  std::ranges::set_difference(any, all, std::inserter(weak, weak.end()));
  REQUIRE(!all.empty());
  REQUIRE(weak.size() > 3);
  const auto sweeps = problem.reduced.sweeps();
  const io::Kink kink = drivers::describe(problem.reduced, certificate);
  CHECK(problem.reduced.sweeps().forward == sweeps.forward);
  CHECK((kink.length == 0.25 && kink.radius == 0.5 && kink.gradients == 3));
  REQUIRE(kink.weak.size() == weak.size());
  auto next = weak.begin();
  const contact::ContactPairs& pairs = *ready.problem.stepper.pairs();
  for (const io::WeakContact& one : kink.weak) {
    CHECK(std::pair(one.step, one.candidate) == *next++);
    CHECK(std::abs(one.time - 0.02 * one.step) < 1e-12);
    REQUIRE(one.x.size() == 2);
    for (std::size_t c = 0; c < 2; ++c)
      CHECK(one.x[c] == pairs.points()[3 * static_cast<std::size_t>(one.candidate) + c]);
  }
  // As a checkpoint keeps it.
  const std::vector<double> stored = drivers::numbers(kink);
  REQUIRE(stored.size() == 3 + 6 * weak.size());
  const std::optional<io::Kink> again = drivers::kink_of(stored, 2);
  REQUIRE(again);
  CHECK(drivers::numbers(*again) == stored);
  CHECK((again->length == 0.25 && again->radius == 0.5 && again->gradients == 3));
  CHECK((again->weak.back().step == kink.weak.back().step && again->weak.back().x == kink.weak.back().x));
  CHECK(!drivers::kink_of(stored, 3));
  CHECK(!drivers::kink_of({1, 2}, 2));
}
