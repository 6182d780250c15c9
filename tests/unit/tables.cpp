// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.h"
#include "diagnostics/impact_summary.h"
#include "diagnostics/probes.h"
#include "diagnostics/warnings.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <numeric>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;
using Settings = std::vector<std::string>;
using Vector = std::array<double, 3>;

namespace {

double length(const Vector& x) { return std::hypot(x[0], x[1], x[2]); }

Vector difference(const Vector& x, const Vector& y) { return {x[0] - y[0], x[1] - y[1], x[2] - y[2]}; }

Settings with(Settings all, const Settings& more) {
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

/// A whole motion by the numbers that tables have.
struct Watched {
  test::Ready ready;
  problem::GivenControl given;
  std::vector<diagnostics::StepBalance> balance;
  std::vector<std::vector<diagnostics::ObstacleForce>> each;
  std::vector<diagnostics::ObstacleForce> all;
  std::vector<std::vector<double>> probes;
  std::optional<diagnostics::ImpactSummary> summary;

  explicit Watched(const std::string& file, const Settings& settings)
      : ready(file, settings), given(ready.problem) {
    const problem::Problem& problem = ready.problem;
    const bool reactions = problem.probes && problem.probes->need_reactions();
    diagnostics::Balance weigh(problem.stepper, {reactions, given.acts(), problem.scene_loads()});
    diagnostics::ObstacleForces forces(problem.stepper);
    summary.emplace(problem.stepper, ready.scene);
    trajectory::integrate(problem.stepper, problem.grid, problem.initial, given.load(),
                          [&](const trajectory::Frame& frame) {
                            balance.push_back(weigh(frame));
                            forces.observe(frame);
                            each.push_back(forces.each());
                            all.push_back(forces.all());
                            summary->observe(frame, balance.back(), forces);
                            probes.emplace_back();
                            if (problem.probes)
                              problem.probes->add_values(frame, forces, weigh.reactions(), probes.back());
                          });
  }

  /// The probes' value of a name at step k.
  [[nodiscard]] double probe(std::size_t k, const std::string& name) const {
    const std::vector<std::string>& names = ready.problem.probes->columns();
    const auto found = std::ranges::find(names, name);
    REQUIRE(found != names.end());
    return probes[k][static_cast<std::size_t>(found - names.begin())];
  }
};

const std::vector<Settings> schemes{
    {}, {"time.scheme=\"contact-stabilized\""}, {"contact.mass=\"massless\""}};

/// Two walls, left and right of nothing: floor and ceiling that close upon the block.
Settings jaws(const std::string& mass = "consistent") {
  return {fmt::format("contact=[{{ on=\"bottom\", mass=\"{0}\", obstacle={{ shape=\"half-space\", "
                      "point=[0, \"min(0.2*t - 0.05, 0.01)\"], normal=[0, 1], name=\"lower jaw\" }} }}, "
                      "{{ on=\"top\", mass=\"{0}\", obstacle={{ shape=\"half-space\", point=[0, \"max(1.05 - "
                      "0.2*t, 0.99)\"], normal=[0, -1] }} }}]",
                      mass),
          "load.body=[\"0\", \"0\"]",
          "initial.velocity=[\"0\", \"0\"]",
          "time.end=3",
          "time.step=0.02",
          "material.viscosity={ bulk=5, shear=5 }"};
}

} // namespace

TEST_CASE("the impulse of contact is the change of momentum less that of the loads", "[forward]") {
  for (const auto& [file, dim] :
       {std::pair{"tests/data/block.toml", std::size_t{2}}, {"tests/data/cube.toml", 3}})
    for (const char* degree : {"mesh.degree=1", "mesh.degree=2"})
      for (const Settings& scheme : schemes) {
        CAPTURE(scheme);
        const Watched motion(file, with({degree, "time.step=0.03"}, scheme));
        const double tau = motion.ready.problem.grid.length(1);
        Vector impulse{},
            change = difference(motion.balance.back().momentum, motion.balance.front().momentum);
        change[dim - 1] += 0.6; // a weight of 1 N for 0.6 s
        double forces = 0;
        for (std::size_t k = 0; k < motion.all.size(); ++k) {
          const diagnostics::ObstacleForce& now = motion.all[k];
          forces = std::max(forces, now.normal_force);
          CHECK(length(difference(now.force, motion.balance[k].contact_force)) <= 1e-13 * now.normal_force);
          CHECK(length(difference(now.force, motion.each[k].front().force)) == 0);
          // One direction: the modulus of the resultant is the sum of moduli.
          CHECK(std::abs(length(now.force) - now.normal_force) <= 1e-13 * now.normal_force);
          for (std::size_t c = 0; c < 3; ++c)
            impulse[c] += tau * now.force[c];
        }
        REQUIRE(forces > 0);
        CHECK(length(difference(impulse, change)) < 1e-11 * length(impulse));
        const diagnostics::Impact impact = *motion.summary->impact();
        CHECK(length(difference(impact.all.impulse, impulse)) < 1e-13 * length(impulse));
        CHECK(std::abs(impact.mass - 1) < 1e-12);
        CHECK(impact.obstacles.front().largest_step == forces);
        CHECK(impact.all.peak <= forces);
      }
}

TEST_CASE("two jaws push with opposite forces whose moduli add", "[forward]") {
  for (const Settings& settings : {jaws(), with(jaws(), {"time.scheme=\"contact-stabilized\""}),
                                   jaws("massless"), with(jaws(), {"mesh.degree=2"})}) {
    CAPTURE(settings);
    const Watched motion("tests/data/block.toml", settings);
    const diagnostics::ObstacleForce &lower = motion.each.back()[0], &upper = motion.each.back()[1],
                                     &all = motion.all.back();
    // Pressed together by 0.02 of its height, free to the sides: E/(1 − ν²) times that. Single forces
    // alternate.
    const double pressed = 50 / (1 - 0.09) * 0.02;
    const std::vector<diagnostics::ObstacleForce>& before = motion.each[motion.each.size() - 2];
    CHECK(std::abs((lower.force[1] + before[0].force[1]) / 2 / pressed - 1) < 0.01);
    CHECK(std::abs((upper.force[1] + before[1].force[1]) / 2 / pressed + 1) < 0.01);
    CHECK(std::abs(all.normal_force - lower.normal_force - upper.normal_force) < 1e-12 * pressed);
    CHECK(all.active == lower.active + upper.active);
    CHECK(all.min_gap == std::min(lower.min_gap, upper.min_gap));
    CHECK(lower.active > 2);
    const diagnostics::Impact impact = *motion.summary->impact();
    CHECK(impact.obstacles[0].name == "lower jaw");
    CHECK(impact.obstacles[1].name == "obstacle 2");
    CHECK(length(impact.all.impulse) < 1e-2 * impact.all.normal_impulse);
    CHECK(std::abs(impact.all.normal_impulse - length(impact.obstacles[0].impulse) -
                   length(impact.obstacles[1].impulse)) < 1e-12 * impact.all.normal_impulse);
    CHECK_FALSE(impact.ended);
    CHECK_FALSE(impact.whole.restitution);
  }
}

TEST_CASE("restitution from velocities is that from the impulse", "[forward]") {
  const Settings thrown{"contact.obstacle.normal=[0, 1]", "load.body=[\"0\", \"0\"]"};
  for (const Settings& scheme : schemes) {
    CAPTURE(scheme);
    const Watched motion("tests/data/block.toml", with(thrown, scheme));
    const diagnostics::Impact impact = *motion.summary->impact();
    REQUIRE(impact.ended);
    REQUIRE(impact.whole.restitution);
    CHECK(*impact.whole.restitution > 0.3);
    CHECK(*impact.whole.restitution < 1);
    const double by_impulse =
        (impact.all.impulse[1] / impact.mass + impact.whole.before[1]) / -impact.whole.before[1];
    CHECK(std::abs(by_impulse - *impact.whole.restitution) < 1e-11);
    CHECK(std::abs(impact.whole.before[1] + 1) < 1e-12);
    const diagnostics::Touch& touch = impact.all;
    CHECK((touch.start >= 0.08 && touch.start <= 0.1)); // 0.1 m at 1 m/s, in steps of 0.02 s
    CHECK((touch.end > touch.start && touch.contact_time <= touch.end - touch.start + 1e-12));
    CHECK((touch.peak_time >= touch.start && touch.peak_time <= touch.end));
    // Where the energy went: nothing but viscosity and contact takes any.
    const diagnostics::EnergyAccount& energy = motion.summary->energy();
    const double end = energy.kinetic_at_end + energy.elastic_at_end;
    CHECK(std::abs(energy.kinetic_at_start - 0.5) < 1e-12);
    CHECK((energy.load_work == 0 && energy.other_work == 0 && energy.contact_work <= 1e-14));
    CHECK(energy.viscous_dissipation > 0);
    CHECK(std::abs(0.5 + energy.contact_work - energy.viscous_dissipation - end) < 1e-12);
  }
  // None where it would have no meaning.
  for (const Settings& other : {Settings{"clamp=[{ on=\"top\", components=[\"y\"], value=[\"-t\"] }]"},
                                {"time.end=0.14"},
                                {"contact.obstacle.point=[0, \"-0.1 + 0.01*t\"]"}}) {
    CAPTURE(other);
    const diagnostics::Impact impact =
        *Watched("tests/data/block.toml", with(thrown, other)).summary->impact();
    CHECK(impact.all.occurred());
    CHECK_FALSE(impact.whole.restitution);
    CHECK_FALSE(impact.no_restitution.empty());
  }
  const diagnostics::Impact none =
      *Watched("tests/data/block.toml", with(thrown, {"time.end=0.08"})).summary->impact();
  CHECK_FALSE(none.all.occurred());
  CHECK_FALSE(none.whole.restitution);
}

TEST_CASE("clamps of a symmetry leave restitution as it is", "[forward]") {
  // Without lateral contraction a flat block moves along y alone, but for its chatter, whether or not x is
  // clamped.
  const Settings falling{"contact.obstacle.normal=[0, 1]", "load.body=[\"0\", \"0\"]", "material.poisson=0",
                         "material.viscosity={ bulk=0, shear=0 }"},
      symmetric{"clamp=[{ on=\"left\", components=[\"x\"] }]"};
  for (const Settings& scheme : schemes) {
    CAPTURE(scheme);
    const auto impact = [&](const Settings& more) {
      return *Watched("tests/data/block.toml", with(with(falling, scheme), more)).summary->impact();
    };
    const diagnostics::Impact free = impact({}), clamped = impact(symmetric);
    REQUIRE(free.whole.restitution);
    REQUIRE(clamped.whole.restitution);
    CHECK(*free.whole.restitution > 0.3);
    CHECK(std::abs(*free.whole.restitution - *clamped.whole.restitution) < 0.005); // of chatter
    const double before = clamped.whole.before[1];
    CHECK(std::abs((clamped.all.impulse[1] / clamped.mass + before) / -before - *clamped.whole.restitution) <
          1e-11);
    CHECK(clamped.no_restitution.empty());
    // Neither of a clamp along the impulse, nor of both components.
    for (const char* other : {"clamp=[{ on=\"top\", components=[\"y\"], value=[\"-t\"] }]",
                              "clamp=[{ on=\"top\", value=[\"0\", \"-t\"] }]"}) {
      CAPTURE(other);
      const diagnostics::Impact held = impact({other});
      CHECK(held.all.occurred());
      CHECK_FALSE(held.whole.restitution);
      CHECK(held.no_restitution == "clamps hold the body in the direction of the contact force");
    }
  }
}

TEST_CASE("the least gap and its time are those of the candidates", "[forward]") {
  // Up by 0.1 m/s, and an obstacle that comes to 0.02 m of it at 0.3 s.
  const Watched motion(
      "tests/data/block.toml",
      {"contact.obstacle={ shape=\"half-space\", point=[0, \"0.1*t - 0.02 - abs(t - 0.3)\"], "
       "normal=[0, 1] }",
       "load.body=[\"0\", \"0\"]", "initial.velocity=[\"0\", \"0.1\"]"});
  const diagnostics::Impact impact = *motion.summary->impact();
  for (const diagnostics::Touch* touch : {&impact.all, &impact.obstacles.front()}) {
    CHECK_FALSE(touch->occurred());
    CHECK(std::abs(touch->least_gap - 0.02) < 1e-12);
    CHECK(std::abs(touch->least_gap_time - 0.3) < 1e-12);
  }
}

TEST_CASE("a flutter of contact is one bounce", "[forward]") {
  // Six times in 16 s by the exact solution; a flutter follows one of the contacts.
  const Watched motion("scenes/bouncing-bar.toml", {});
  const diagnostics::Impact impact = *motion.summary->impact();
  int touches = 0, open = 0;
  bool parted = true;
  for (std::size_t k = 1; k < motion.all.size(); ++k) {
    const bool pushed = motion.all[k].normal_force > 0;
    touches += pushed && parted;
    open = pushed || motion.all[k].active > 0 ? 0 : open + 1;
    parted = !pushed && (parted || open >= 2);
  }
  REQUIRE(touches >= 6); // whether it flutters hangs on rounding
  CHECK(impact.whole.touches == touches);
  CHECK(impact.bounces.size() == 6);
  int sum = 0;
  double last = 0;
  for (const diagnostics::Rebound& bounce : impact.bounces) {
    sum += bounce.touches;
    CHECK(bounce.start - last > 2 * 10 / 30.0); // a wave's way there and back, at 30 m/s
    CHECK(bounce.restitution);
    last = bounce.end;
  }
  CHECK(sum == touches);
}

TEST_CASE("bounces are told one by one, with free fall between them", "[forward]") {
  const Settings falling{"contact.obstacle.normal=[0, 1]", "load.body=[\"0\", \"-4\"]", "time.end=3"};
  for (const Settings& scheme : schemes) {
    CAPTURE(scheme);
    const Watched motion("tests/data/block.toml", with(falling, scheme));
    const diagnostics::Impact impact = *motion.summary->impact();
    const std::vector<diagnostics::Rebound>& bounces = impact.bounces;
    REQUIRE(bounces.size() >= 3);
    Vector sum{};
    for (std::size_t i = 0; i < bounces.size(); ++i) {
      const diagnostics::Rebound& one = bounces[i];
      const double duration = one.end - one.start;
      CHECK(std::abs(impact.mass * (one.after[1] - one.before[1] + 4 * duration) - one.impulse[1]) < 1e-11);
      for (std::size_t c = 0; c < 3; ++c)
        sum[c] += one.impulse[c];
      double largest = 0;
      for (std::size_t k = 1; k < motion.all.size(); ++k)
        if (const double t = 0.02 * static_cast<double>(k); t > one.start - 0.01 && t < one.end + 0.03)
          largest = std::max(largest, (motion.all[k - 1].normal_force + motion.all[k].normal_force) / 2);
      CHECK(std::abs(one.peak - largest) <= 1e-12 * largest);
      if (i > 0)
        CHECK(std::abs(bounces[i - 1].after[1] - 4 * (one.start - bounces[i - 1].end) - one.before[1]) <
              1e-11);
      if (one.restitution)
        CHECK(std::abs(*one.restitution + one.after[1] / one.before[1]) < 1e-12);
    }
    CHECK(length(difference(sum, impact.whole.impulse)) < 1e-11);
    CHECK(bounces.front().restitution);
    CHECK((impact.whole.start == bounces.front().start && impact.whole.end == bounces.back().end));
    CHECK(impact.whole.before == bounces.front().before);
    CHECK(impact.whole.after == bounces.back().after);
    CHECK(impact.no_restitution.empty() == impact.whole.restitution.has_value());
  }
}

TEST_CASE("a peak as contact begins is marked whatever the step, one that builds up is not", "[forward]") {
  const auto peak = [](const Settings& settings) {
    return Watched("tests/data/block.toml", with({"contact.obstacle.normal=[0, 1]"}, settings))
        .summary->impact()
        ->all;
  };
  // The mass of a flat face stops within a step, the shorter the harder.
  double before = 0;
  for (const char* step : {"time.step=0.005", "time.step=0.0025", "time.step=0.00125"}) {
    CAPTURE(step);
    const diagnostics::Touch hit = peak({step});
    CHECK(hit.peak_at_onset);
    CHECK(hit.peak > 1.05 * before);
    before = hit.peak;
  }
  // Pressed slowly by a weight that grows.
  const diagnostics::Touch pressed = peak({"initial.velocity=[\"0\", \"0\"]", "load.body=[\"0\", \"-t\"]",
                                           "contact.obstacle.point=[0, 0]", "time.end=2"});
  CHECK((pressed.occurred() && !pressed.peak_at_onset));
}

TEST_CASE("the work of loads is told apart from that of a control", "[forward]") {
  for (const char* body : {"load.body=[\"0\", \"-1\"]", "load.body=[\"0\", \"-1 - 0*t\"]"}) {
    CAPTURE(body);
    const Watched motion("tests/data/block.toml", {body, "control.initial=[\"0.3\", \"-0.5\"]",
                                                   "clamp=[{ on=\"left\", "
                                                   "components=[\"x\"], value=[\"0.1*t^2\"] }]",
                                                   "output.probe=[{ body=true }]"});
    double control = 0;
    for (std::size_t k = 1; k < motion.balance.size(); ++k) {
      const double fallen = motion.probe(k, "probe 1.center_y") - motion.probe(k - 1, "probe 1.center_y");
      CHECK(std::abs(motion.balance[k].load_work + fallen) < 1e-13); // of a body of 1 kg
      control += motion.balance[k].external_work - motion.balance[k].load_work;
    }
    CHECK(std::abs(control - motion.summary->energy().other_work) < 1e-13);
    CHECK(std::abs(control) > 1e-3);
  }
  const Watched pushed("tests/data/block.toml",
                       {"load.body=[\"0\", \"0\"]", "control.initial=[\"0\", \"-1\"]"});
  CHECK(pushed.summary->energy().load_work == 0);
  CHECK(std::abs(pushed.summary->energy().other_work) > 1e-3);
}

TEST_CASE("probes see linear motions as they are", "[forward]") {
  // The square's and the cube's moments of inertia are those of a ball: the mean rotation is that of ∇y.
  const std::string plane = "output.probe=[{ name=\"p\", point=[0.3, 0.7] }, { on=\"top\" }, { name=\"b\", "
                            "body=true }, { on=\"body\", name=\"v\" }]",
                    space = "output.probe=[{ name=\"p\", point=[0.3, 0.7, 0.2] }, { on=\"top\" }, { "
                            "name=\"b\", body=true }, { on=\"body\", name=\"v\" }]";
  for (const auto& [file, dim, probes] :
       {std::tuple{"tests/data/block.toml", 2, plane}, {"tests/data/cube.toml", 3, space}})
    for (const char* degree : {"mesh.degree=1", "mesh.degree=2"}) {
      const test::Ready ready(file, {probes, degree});
      const problem::Problem& problem = ready.problem;
      const auto n = static_cast<std::size_t>(dim);
      const double G[3][3] = {{0.1, -0.3, 0.2}, {0.5, 0.4, -0.1}, {-0.6, 0.7, 0.3}}, shift[3] = {1, 2, 3};
      const auto value = [&](const std::vector<double>& x, std::size_t c) {
        return shift[c] + std::inner_product(x.begin(), x.end(), G[c], 0.0);
      };
      scene::Components y, v;
      for (std::size_t c = 0; c < n; ++c) {
        y.push_back(fmt::format("{} + {}*x + {}*y + {}*z", shift[c], G[c][0], G[c][1], n == 3 ? G[c][2] : 0));
        v.push_back("2*(" + y.back().text + ")");
      }
      const step::State state = problem.stepper.state();
      problem.space.interpolate(scene::Field(y, "test", false), 0, state.y());
      problem.space.interpolate(scene::Field(v, "test", false), 0, state.v());
      const contact::ContactState contact(problem.stepper.pairs()->count());
      std::vector<double> found;
      const trajectory::Frame frame{problem.grid.step(1), nullptr, {}, state, contact, false};
      problem.probes->add_values(frame, diagnostics::ObstacleForces(problem.stepper), nullptr, found);
      std::vector<double> point{0.3, 0.7, 0.2}, top(n, 0.5), centre(n, 0.5);
      point.resize(n);
      top[n - 1] = 1;
      std::vector<double> expected;
      const auto expect = [&](const std::vector<double>& x, double factor, bool place) {
        for (std::size_t c = 0; c < n; ++c)
          expected.push_back(factor * value(x, c) + (place ? x[c] : 0));
      };
      expect(point, 1, false), expect(point, 2, false), expect(top, 1, false), expect(top, 2, false);
      expect(centre, 1, true), expect(centre, 2, false);
      if (n == 2)
        expected.push_back((G[1][0] - G[0][1]) / 2);
      else
        for (std::size_t a = 0; a < 3; ++a)
          expected.push_back((G[(a + 2) % 3][(a + 1) % 3] - G[(a + 1) % 3][(a + 2) % 3]) / 2);
      expect(centre, 1, false), expect(centre, 2, false);
      REQUIRE(found.size() == expected.size());
      REQUIRE(found.size() == problem.probes->columns().size());
      CHECK(problem.probes->columns()[0] == "p.displacement_x");
      CHECK(problem.probes->columns()[2 * n] == "probe 2.displacement_x");
      for (std::size_t i = 0; i < found.size(); ++i) {
        INFO(problem.probes->columns()[i]);
        CHECK(std::abs(found[i] - expected[i]) < 1e-12);
      }
    }
}

TEST_CASE("what clamps, obstacles and loads do is the rate of momentum, by probes too", "[forward]") {
  const std::string probes =
      "output.probe=[{ name=\"held\", on=\"left\" }, { name=\"floor\", obstacle=\"obstacle 1\" }, { "
      "name=\"body\", body=true }]";
  for (const char* value : {"[\"0\", \"0\"]", "[\"0.3*sin(3*t)^2\", \"-0.5*t^2\"]"})
    for (const Settings& scheme : schemes) {
      CAPTURE(scheme);
      const std::string clamp = fmt::format("clamp=[{{ on=\"left\", value={} }}]", value);
      const Watched motion("tests/data/block.toml",
                           with({probes, clamp, "initial.velocity=[\"0\", \"0\"]",
                                 "contact.obstacle.point=[0, -0.02]", "load.body=[\"0\", \"-3\"]"},
                                scheme));
      const double tau = motion.ready.problem.grid.length(1);
      double reactions = 0, forces = 0;
      for (std::size_t k = 1; k < motion.balance.size(); ++k) {
        for (const auto& [axis, weight] : {std::pair{"x", 0.0}, {"y", -3.0}}) {
          CAPTURE(axis, weight);
          const auto probe = [&](const char* name) {
            return motion.probe(k, fmt::format("{}_{}", name, axis));
          };
          const double before = motion.probe(k - 1, fmt::format("body.momentum_{}", axis)),
                       rate = (probe("body.momentum") - before) / tau,
                       sum = probe("held.reaction") + probe("floor.force") + weight;
          reactions = std::max(reactions, std::abs(probe("held.reaction")));
          forces = std::max(forces, std::abs(probe("floor.force")));
          CHECK(std::abs(rate - sum) < 1e-11 * (1 + reactions));
        }
        CHECK(std::abs(motion.probe(k, "floor.impulse_y") - motion.probe(k - 1, "floor.impulse_y") -
                       tau * motion.probe(k, "floor.force_y")) < 1e-12);
      }
      CHECK((reactions > 1 && forces > 0.1));
    }
}

TEST_CASE("a probe that is not of the body is refused", "[forward]") {
  const auto refused = [](const std::string& probe) {
    return test::Ready("tests/data/block.toml", {"output.probe=[{ body=true }, { " + probe + " }]"});
  };
  CHECK_THROWS_WITH(refused("point=[0.5, -0.1]"),
                    ContainsSubstring("output.probe[1].point: found (0.5, -0.1)") &&
                        ContainsSubstring("0.1 m outside"));
  CHECK_THROWS_WITH(refused("on=\"tpo\""),
                    ContainsSubstring("output.probe[1].on") && ContainsSubstring("top"));
  CHECK_NOTHROW(refused("point=[0.5, -0.001]")); // a coarse mesh of a curved boundary leaves that much out
}

TEST_CASE("contact that changes for a single step is counted", "[forward]") {
  const auto counted = [](const std::vector<contact::ActiveSet>& active) {
    std::vector<contact::ContactLinearisation> sets(1);
    for (const contact::ActiveSet& set : active)
      sets.push_back({set, {}, {}});
    return diagnostics::alternations(sets);
  };
  CHECK(counted({{}, {0, 1}, {0, 1}, {0, 1}, {}}).alternating == 0);
  CHECK(counted({{}, {0, 1}, {0, 1}, {0, 1}, {}}).closed == 6);
  CHECK(counted({{}, {0, 1}, {0, 1}, {1}, {0, 1}, {0, 1}, {}}).alternating == 1); // 0 opens once
  CHECK(counted({{}, {2}, {}, {2}, {}, {}}).alternating == 3); // closes, opens, closes for one step
  CHECK(counted({{3}, {3}}).alternating == 0);
  const test::Ready implicit("tests/data/block.toml"),
      stabilized("tests/data/block.toml", {"time.scheme=\"contact-stabilized\""});
  CHECK(diagnostics::calmer_contact(implicit.problem.stepper).find("contact-stabilized") !=
        std::string::npos);
  CHECK(diagnostics::calmer_contact(stabilized.problem.stepper).find("contact-stabilized") ==
        std::string::npos);
}

TEST_CASE("a contact zone's spacing comes from Hertz's radius and the curvature of the gap", "[contact]") {
  constexpr double R = 15, modulus = 1e8;
  for (const char* degree : {"mesh.degree=1", "mesh.degree=2"}) {
    CAPTURE(degree);
    const test::Ready ready("scenes/half-ball.toml",
                            {"mesh.size=3", degree, "control.initial=[\"0\", \"0\", \"0\"]"});
    const contact::ContactPairs& pairs = *ready.problem.stepper.pairs();
    const auto lowest = std::ranges::min_element(pairs.psi()) - pairs.psi().begin();
    const auto spacing = [&](double radius, int most) { // a force whose Hertz zone has that radius
      const double force = 4 * modulus * radius * radius * radius / (3 * R);
      return diagnostics::candidate_spacing(pairs, static_cast<int>(lowest), most, force, modulus);
    };
    const diagnostics::CandidateSpacing small = spacing(0.5, 1), large = spacing(30, 2);
    const double unit = *degree == '1' ? 1 : 0.5;
    CHECK((small.found > 0.6 * 3 * unit / 2 && small.found < 1.4 * 3));
    CHECK(std::abs(small.enough / (0.7 * 0.5) - 1) < 0.1); // the sphere's gap is no paraboloid, quite
    CHECK(std::abs(large.enough / (large.found * std::sqrt(0.4)) - 1) <
          1e-12); // at most what five nodes ask for
  }
  // In the plane: of a half-width a under F, a² = 4 F R/(π E*); two nodes on either side within 0.7 a.
  const test::Ready ready("scenes/half-disc.toml", {"mesh.size=1"});
  const contact::ContactPairs& pairs = *ready.problem.stepper.pairs();
  const auto lowest = std::ranges::min_element(pairs.psi()) - pairs.psi().begin();
  const auto spacing = [&](double half, int most) {
    return diagnostics::candidate_spacing(pairs, static_cast<int>(lowest), most,
                                          std::numbers::pi * modulus * half * half / (4 * R), modulus);
  };
  const diagnostics::CandidateSpacing small = spacing(0.5, 1), large = spacing(30, 2);
  CHECK((small.found > 0.5 && small.found < 1.5));
  CHECK(std::abs(small.enough / (0.35 * 0.5) - 1) < 0.1);
  CHECK(std::abs(large.enough / (large.found * 0.4) - 1) < 1e-12);
}

TEST_CASE("frames are stored a few hundred times, where nothing else is said", "[scene]") {
  for (const auto& [steps, every] : {std::pair{1, 1},
                                     {150, 1},
                                     {300, 1},
                                     {301, 2},
                                     {600, 2},
                                     {601, 5},
                                     {1500, 5},
                                     {1501, 10},
                                     {3000, 10},
                                     {3001, 20},
                                     {100'000'000, 500'000}}) {
    CAPTURE(steps, every);
    CHECK(scene::Output::automatic(steps) == every);
  }
  const auto every = [](const Settings& settings) {
    return test::parse(test::source("tests/data/block.toml"), settings).output.every;
  };
  CHECK(every({}) == 1);
  CHECK(every({"time.step=1e-4"}) == 20); // 6000 steps
  CHECK(every({"time.step=1e-4", "output.every=1"}) == 1);
}
