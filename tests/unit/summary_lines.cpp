// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/summary_lines.h"
#include "drivers/fit_outcome.h"
#include <array>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;

TEST_CASE("work that is rounding is no part of the account", "[io]") {
  io::Manifest m;
  m.body.per_depth = "/m";
  diagnostics::EnergyAccount& energy = m.energy.emplace();
  energy.kinetic_at_start = 2, energy.load_work = 0.5, energy.contact_work = 7.389e-42;
  energy.other_work = -0.25, energy.viscous_dissipation = 1, energy.kinetic_at_end = 1,
  energy.elastic_at_end = 0.25;
  CHECK(drivers::summary_lines(m) ==
        std::vector<std::string>{
            "energy, kinetic and elastic: 2 J/m at the start, +0.5 by loads, -0.25 by control and "
            "clamps, -1 by viscosity: 1.25 at the end, 0.25 of it elastic"});
  energy.contact_work = -0.125; // what is no rounding is there
  CHECK_THAT(drivers::summary_lines(m).front(), ContainsSubstring(", -0.125 by contact, -1 by viscosity"));
}

TEST_CASE("energy and dissipation of branches are named in the account", "[io]") {
  io::Manifest m;
  m.body.per_depth = "/m";
  diagnostics::EnergyAccount& energy = m.energy.emplace();
  energy.kinetic_at_start = 2, energy.relaxation_dissipation = 0.5, energy.kinetic_at_end = 1,
  energy.elastic_at_end = 0.25, energy.relaxation_at_end = 0.25;
  CHECK(drivers::summary_lines(m) ==
        std::vector<std::string>{"energy, kinetic and elastic, with that of branches: 2 J/m at the start, "
                                 "-0.5 by relaxation: 1.5 at the end, 0.25 of it elastic, 0.25 in branches"});
  energy.foundation_at_end = 0.125;
  CHECK_THAT(drivers::summary_lines(m).front(),
             ContainsSubstring("with that of foundations and branches") &&
                 ContainsSubstring(", 0.125 in foundations, 0.25 in branches"));
}

TEST_CASE("contact that never closed is told by its least gap", "[io]") {
  io::Manifest m;
  diagnostics::Impact& impact = m.impact.emplace();
  impact.obstacles = {{.name = "floor"}, {.name = "wall"}};
  impact.obstacles[0].least_gap = impact.all.least_gap = 0.0125;
  impact.obstacles[0].least_gap_time = impact.all.least_gap_time = 0.375;
  impact.obstacles[1].least_gap = 2, impact.obstacles[1].least_gap_time = 0.5;
  CHECK(drivers::summary_lines(m) ==
        std::vector<std::string>{"contact: none; the least gap was 0.0125 m, at 0.375 s"});
  impact.obstacles[0].contact_time = impact.all.contact_time = 0.1;
  const std::vector<std::string> lines = drivers::summary_lines(m);
  REQUIRE(lines.size() == 4);
  CHECK(lines[2] == "  wall: not touched; the least gap was 2 m, at 0.5 s");
}

TEST_CASE("bounces and touches are counted apart", "[io]") {
  io::Manifest m;
  diagnostics::Impact& impact = m.impact.emplace();
  impact.obstacles = {{.name = "floor", .contact_time = 0.1}};
  impact.all.contact_time = 0.1;
  impact.ended = true;
  impact.whole.touches = 13;
  impact.whole.restitution = 0.5;
  impact.bounces = {{.touches = 13, .restitution = 0.5}};
  const auto has = [&](const char* text) {
    std::string all;
    for (const std::string& line : drivers::summary_lines(m))
      all += line + "\n";
    return all.find(text) != std::string::npos;
  };
  CHECK(has("restitution 0.5 over one bounce of 13 touches\n"));
  CHECK_FALSE(has("bounce 1 of 1")); // the body as a whole says it all
  impact.bounces = {{.touches = 12}, {.touches = 1}};
  CHECK(has("restitution 0.5 over all 2 bounces of 13 touches\n"));
  CHECK(has("bounce 1 of 2: from 0 to 0 s in 12 touches, impulse"));
  CHECK(has("bounce 2 of 2: from 0 to 0 s, impulse"));
  impact.whole.touches = 2;
  CHECK(has("restitution 0.5 over all 2 bounces\n"));
  impact.whole.touches = 1;
  impact.bounces = {{}};
  CHECK(has("restitution 0.5\n"));
}

TEST_CASE("the outcome of a fit has every number where it belongs", "[io]") {
  io::Fit fit;
  fit.unknowns = {{.name = "young", .unit = "Pa", .value = 2e6, .deviation = 1250, .start = 1e6},
                  {.name = "shear viscosity", .unit = "Pa s", .deviation = INFINITY, .start = 3},
                  {.name = "throw", .value = -1.5, .deviation = 0.25, .start = -1, .at_bound = true}};
  fit.unidentified = {"The data do not determine shear viscosity."};
  fit.compared = {{"contact_start", "s", 0.25, 0.01, 0.27}, {"contact_end", "s", 0.5, 0, NAN}};
  fit.data = 12, fit.misfit = 0.416;
  const std::array<std::string, 3> pairs{"-0.70, of young and shear viscosity", "-0.70, of young and throw",
                                         "-0.70, of shear viscosity and throw"};
  std::size_t pair = 0;
  for (const auto& [i, j] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)}) {
    CAPTURE(i, j);
    fit.correlations = {1, 0.1, 0.1, 0.1, 1, 0.1, 0.1, 0.1, 1};
    fit.correlations[static_cast<std::size_t>(3 * i + j)] =
        fit.correlations[static_cast<std::size_t>(3 * j + i)] = -0.7;
    CHECK(drivers::outcome_lines(fit) ==
          std::vector<std::string>{
              "unknown                   value     deviation         start",
              "young                   2000000      1.25e+03         1e+06  Pa",
              "shear viscosity               0  undetermined             3  Pa s",
              "throw                      -1.5          0.25            -1   (at its bound)",
              "largest correlation: " + pairs[pair++], "The data do not determine shear viscosity.",
              "contact_start: measured 0.25 s, simulated 0.27 s, off by +2.00 standard deviations",
              "contact_end: measured 0.5 s, simulated no contact",
              "misfit of 12 values: 0.416 standard deviations (root mean square)"});
  }
}
