// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/text.h"
#include "scene/rules.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::scene {

namespace {

/// Whether a scenario may change a key: the space, the steps and the control are those of all scenarios.
bool changeable(const std::string& key) {
  constexpr std::string_view admitted[] = {"material", "foundation",       "clamp", "contact", "load",
                                           "initial",  "objective.desired"};
  return std::ranges::any_of(admitted, [&](std::string_view table) {
    return key.starts_with(table) && (key.size() == table.size() || key[table.size()] == '.');
  });
}

} // namespace

void require_rules(Reader& in, Scenario& scenario, const Scene& scene) {
  scenario.name =
      unique_name(in, fmt::format("scenario {}", scene.scenarios.size()), scene.scenarios, "scenario");
  for (const Change& change : scenario.set)
    if (!changeable(change.key))
      in.fail("set", fmt::format("found \"{}\", which is the same in all scenarios; expected keys of "
                                 "material, foundation, clamp, contact, load, initial or objective.desired",
                                 change.key));
}

void require_scenario_rules(Reader& in, const Scene& scene) {
  if (scene.scenarios.empty()) {
    if (scene.objective && scene.objective->exponent != 1)
      in.fail("objective.exponent", "has no effect without scenarios; add tables [[scenario]], or remove it");
    return;
  }
  if (!scene.objective)
    in.fail("scenario", "needs a control and an objective; add [control] and [objective]");
  if (!scene.unknowns.empty())
    in.fail("scenario", "found together with [[unknown]]; give only one of them");
  if (scene.time.automatic())
    in.fail("scenario", "found with steps of varying length, which one motion chooses; give time.step");
  if (std::ranges::all_of(scene.scenarios, [](const Scenario& one) { return one.weight == 0; }))
    in.fail("scenario", "found no weight above 0; give at least one");
  if (scene.trajectory.storage == Storage::checkpoints &&
      std::holds_alternative<DesiredControl>(scene.objective->desired))
    in.fail("scenario", "found with trajectory.storage = \"checkpoints\" and objective.desired.control, "
                        "whose motion all scenarios read; use \"disk\" or \"memory\"");
}

} // namespace signorini::scene
