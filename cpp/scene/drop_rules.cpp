// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/text.h"
#include "scene/drop.h"
#include "scene/expression.h"
#include "scene/rules.h"
#include "scene/table.h"
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini::scene {

namespace {

/// Throws UserError unless a body can be dropped.
void require_drop(Reader& in, const Initial& initial, const Scene& scene) {
  const auto fail = [&](const char* what) { in.fail("drop", what); };
  if (scene.contacts.empty())
    fail("has no meaning without contact; add a table [contact]");
  if (std::ranges::all_of(scene.contacts, [](const Contact& one) { return one.against.has_value(); }))
    fail("found with contact.against alone, where no obstacle stops a fall; give initial.velocity, √(2 g h)");
  if (!scene.load || !scene.load->gravity || vanishes(*scene.load->gravity))
    fail("needs the acceleration of its fall; give load.gravity");
  if (Field(*scene.load->gravity, "load.gravity", true).depends_on_time())
    fail("found with a load.gravity that contains t; give numbers");
  if (!(fall(*scene.load->gravity, initial.drop->height).acceleration > 0))
    fail("found with a load.gravity of 0; give the acceleration of its fall");
  if (initial.velocity)
    fail("found together with initial.velocity, which follows from the height; remove one of them");
  if (initial.equilibrium)
    fail("found together with initial.static; remove one of them");
  if (!scene.clamps.empty())
    fail("found with a clamp, which holds the body; remove the clamp");
}

} // namespace

void require_rules(Reader& in, const Initial& initial, const Scene& scene) {
  if (initial.equilibrium && scene.rigid())
    in.fail("static", "found with an obstacle that has mass, whose place of rest is not searched; remove it");
  if (initial.equilibrium && initial.displacement)
    in.fail("static", "found together with initial.displacement, which it replaces; remove one of them");
  if (initial.drop)
    require_drop(in, initial, scene);
}

void set_latest_end(Reader& in, Scene& scene) {
  const auto fail = [&](const std::string& what) { in.fail("time.end", "found \"auto\" " + what); };
  if (!scene.initial.drop)
    fail("without initial.drop; give the end in s");
  for (const char* key : {"control", "unknown", "measurement", "exact"})
    if (in.has(key))
      fail(fmt::format("with {}, which needs an end that is known; give it in s", key));
  if (!time_series(scene).empty())
    fail("with a time series; give it in s");
  Time& time = scene.time;
  const double steps = std::ceil(fall(scene).flight_time() / time.step);
  if (steps > Time::most_steps)
    in.fail("time.step",
            fmt::format("found {:.10g} s, which gives {:.10g} steps of a bounce at most; choose a "
                        "length that gives up to {} steps",
                        time.step, steps, Time::most_steps));
  time.steps = static_cast<int>(steps);
  time.end = time.steps * time.step;
}

void require_rules(Reader& in, Probe& probe, const Scene& scene) {
  const std::vector<Probe>& probes = scene.output.probes;
  probe.name = unique_name(in, fmt::format("probe {}", probes.size()), probes, "output.probe");
  std::vector<std::string> found;
  for (const char* key : {"point", "on", "obstacle", "body"})
    if (in.has(key))
      found.emplace_back(key);
  if (found.empty())
    in.finish(); // reports a misspelt key, the likeliest reason
  if (found.size() != 1)
    in.fail("", fmt::format("found {}; give one of point, on, obstacle, body",
                            found.empty() ? "none of them" : list(found)));
  if (probe.body && !*probe.body)
    in.fail("body", "found false; set it to true, or remove the table");
  if (probe.obstacle && !probe.acceleration)
    require_obstacle(in, *probe.obstacle, scene);
  if (probe.obstacle && probe.acceleration) {
    require_mass(in, *probe.obstacle, scene);
    require_inert(in, *probe.obstacle, scene, "acceleration");
  }
  if (!probe.filter)
    return;
  if (!probe.acceleration && !probe.obstacle)
    in.fail("filter", "has no effect on displacements and velocities; add acceleration = true");
  if (scene.time.automatic())
    in.fail("filter",
            "found with time.step = \"auto\", but filters need steps of equal length; give time.step");
  if (const double longest = probe.filter->longest_sampling(); scene.time.step > longest)
    in.fail("filter",
            fmt::format("found CFC {:.6g}, which needs samples at least every {:.3g} s, but time.step is "
                        "{:.3g} s; choose a shorter step or a lower class",
                        probe.filter->cfc, longest, scene.time.step));
}

} // namespace signorini::scene
