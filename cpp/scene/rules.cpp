// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/rules.h"
#include "base/error.h"
#include "base/text.h"
#include "scene/expression.h"
#include "scene/key_reference.h"
#include "scene/targets.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::scene {

namespace {

/// Returns end / step, the number of steps to `end` (s). Throws UserError unless the quotient is whole.
int whole_steps(Reader& in, double end, double step, const std::string& key) {
  const double steps = std::round(end / step);
  if (!(steps >= 1 && steps <= Time::most_steps))
    in.fail("step",
            fmt::format(
                "found {:.10g} s, which gives {:.10g} steps until time.end = {:.10g} s; choose a length that "
                "gives 1 to {} steps",
                step, end / step, end, Time::most_steps));
  // Decimal fractions such as 7.5e-3 / 5e-5 divide to within a few units in the last place.
  if (std::abs(steps * step - end) > 1e-9 * end)
    in.fail(key == "time.step" ? "end" : "step",
            key == "time.step" ? fmt::format("found {:.10g} s, which is {:.10g} steps of {:.10g} s; choose a "
                                             "whole multiple of {}, such as {:.10g} s",
                                             end, end / step, step, key, steps * step)
                               : fmt::format("found {:.10g} s, but time.end = {:.10g} s is {:.10g} times as "
                                             "long; choose a length that divides time.end, such as {:.10g} s",
                                             step, end, end / step, end / steps));
  return static_cast<int>(steps);
}

} // namespace

void require_rules(Reader& in, Time& time, const Scene&) {
  if (time.end == 0 && time.automatic())
    in.fail("end", "found \"auto\" together with time.step = \"auto\"; give one of them in s");
  if (!time.automatic()) {
    for (const char* key : {"tolerance", "quantity", "longest", "shortest"})
      if (in.has(key))
        in.fail(key, "has no effect on steps of equal length; use it with time.step = \"auto\"");
  } else {
    const double longest = time.longest.value_or(time.end);
    if (longest > time.end)
      in.fail("longest",
              fmt::format("found {:.10g} s; expected at most time.end = {:.10g} s", longest, time.end));
    if (time.shortest.value_or(0) > longest)
      in.fail("shortest", fmt::format("found {:.10g} s; expected at most {} = {:.10g} s", *time.shortest,
                                      time.longest ? "time.longest" : "time.end", longest));
    if (longest * Time::most_steps < time.end)
      in.fail(
          "longest",
          fmt::format(
              "found {:.10g} s, which gives more than {} steps until time.end = {:.10g} s; choose a longer "
              "step",
              longest, Time::most_steps, time.end));
    return;
  }
  if (time.end == 0) { // "auto"; the end is set when all tables are read
    time.until_bounce = true;
    time.steps = Time::most_steps;
    time.end = time.steps * time.step;
    return;
  }
  time.steps = whole_steps(in, time.end, time.step, "time.step");
}

ContactScheme Scene::contact_scheme() const {
  const auto without = std::ranges::count_if(contacts, &Contact::massless);
  if (without > 0)
    return without == std::ssize(contacts) ? ContactScheme::massless : ContactScheme::mixed;
  return time.scheme == TimeScheme::contact_stabilized ? ContactScheme::contact_stabilized
                                                       : ContactScheme::contact_implicit;
}

void require_rules(Reader& in, Control& control, const Scene& scene) {
  if (control.step && control.constant_in_time)
    in.fail("step", "has no effect on a control that is constant in time; remove step or constant_in_time");
  if (control.step)
    control.intervals = whole_steps(in, scene.time.end, *control.step, "control.step");
  if (!control.lower || !control.upper)
    return;
  const std::vector<double>&lower = *control.lower, &upper = *control.upper;
  if (lower.size() > 1 && upper.size() > 1 && lower.size() != upper.size())
    in.fail("upper", fmt::format("found {} components, but lower has {}; give as many, or one number",
                                 upper.size(), lower.size()));
  for (std::size_t i = 0; i < std::max(lower.size(), upper.size()); ++i) {
    const double least = lower.size() == 1 ? lower.front() : lower[i];
    const double most = upper.size() == 1 ? upper.front() : upper[i];
    if (!(least <= most))
      in.fail("lower", fmt::format("found {}, above control.upper = {}; reduce it", least, most));
  }
}

void require_rules(Reader& in, const Objective& objective, const Scene& scene) {
  if (objective.obstacle) {
    require_mass(in, *objective.obstacle, scene);
    if (objective.on)
      in.fail("on", "found together with obstacle; give only one of them");
    if (std::holds_alternative<DesiredRun>(objective.desired))
      in.fail("desired", "found a run, which stores no motion of obstacles; give displacement or control");
  }
  if (objective.tracking == 0 && objective.gamma == 0)
    in.fail("tracking", "found 0, and gamma is 0 too; set at least one of them above 0");
}

void require_rules(Reader& in, const Optimizer& optimizer, const Scene& scene) {
  if (!scene.objective || optimizer.start != SearchStart::coarse)
    return;
  if (const std::string reason = no_coarse_start(scene); !reason.empty())
    in.fail("start", fmt::format("found \"coarse\" {}", reason));
}

void require_rules(Reader& in, const Trajectory& trajectory, const Scene&) {
  if (in.has("budget") && trajectory.storage != Storage::checkpoints)
    in.fail("budget",
            fmt::format(
                "has no effect with storage = \"{}\", which keeps every state; use it with \"checkpoints\"",
                name(trajectory.storage)));
}

std::string unique_name(Reader& in, const std::string& otherwise, const std::vector<std::string>& others,
                        const char* table) {
  const std::string name = in.has("name") ? in.text("name") : otherwise;
  if (name.find_first_of(",\"") != std::string::npos)
    in.fail("name", fmt::format("found '{}'; expected a text without commas "
                                "and quotes, since it is written to tables",
                                name));
  if (const auto other = std::ranges::find(others, name); other != others.end())
    in.fail("name", fmt::format("found \"{}\", which is the name of {}[{}] too; choose another", name, table,
                                other - others.begin()));
  return name;
}

void require_obstacle(const Reader& in, const std::string& obstacle, const Scene& scene) {
  if (scene.contacts.empty())
    in.fail("obstacle", "has no meaning without contact; add a table [contact]");
  std::vector<std::string> names;
  for (const Contact& contact : scene.contacts)
    names.push_back(contact.name);
  if (std::ranges::find(names, obstacle) == names.end())
    in.fail("obstacle",
            fmt::format("found \"{}\"{}; choices: {}", obstacle, suggestion(obstacle, names), list(names)));
}

namespace {

/// The obstacle of a name that exists.
const Contact& named(const Scene& scene, const std::string& obstacle) {
  return scene.contacts[static_cast<std::size_t>(obstacle_number(scene.contacts, obstacle))];
}

} // namespace

void require_mass(const Reader& in, const std::string& obstacle, const Scene& scene) {
  require_obstacle(in, obstacle, scene);
  if (!named(scene, obstacle).rigid)
    in.fail("obstacle",
            fmt::format("found \"{}\", which does not move freely; give this obstacle a mass", obstacle));
}

void require_inert(const Reader& in, const std::string& obstacle, const Scene& scene, const char* key) {
  if (named(scene, obstacle).rigid->mass == 0)
    in.fail(key,
            fmt::format("has no meaning for \"{}\", whose mass is 0: only its displacement is determined; "
                        "give a mass, or use the displacement",
                        obstacle));
}

std::string obstacle_name(Reader& in, const Scene& scene) {
  return unique_name(in, fmt::format("obstacle {}", scene.contacts.size()), scene.contacts, "contact");
}

std::string pair_name(const Reader& in, const Contact& contact, const Scene& scene) {
  const std::string name = contact.on + "/" + contact.against.value();
  for (std::size_t i = 0; i + 1 < scene.contacts.size(); ++i)
    if (scene.contacts[i].name == name)
      in.fail("against", fmt::format("found \"{}\" on \"{}\", as in contact[{}]; remove one of them",
                                     *contact.against, contact.on, i));
  return name;
}

void require_rules(Reader& in, const Solver& solver, const Scene& scene) {
  if (solver.vi == ViMethod::full && scene.several_bodies())
    in.fail("vi",
            "found \"full\" with contact.against, whose constraints are no bounds on unknowns; leave it "
            "out");
  if (solver.vi == ViMethod::full && scene.rigid())
    in.fail("vi",
            "found \"full\" with an obstacle that has mass, whose constraints are no bounds on unknowns; "
            "leave it out");
  if (solver.vi == ViMethod::full && scene.frictional())
    in.fail("vi", "found \"full\" with contact.friction, whose steps are no variational inequality in the "
                  "displacements; use \"condensed\"");
}

void require_rules(Reader& in, const Output& output, const Scene& scene) {
  if (output.field(StoredField::pressure) && scene.contacts.empty())
    in.fail("fields", "found \"pressure\", which has no meaning without contact; add a table [contact]");
  if (output.field(StoredField::friction) && !scene.frictional())
    in.fail("fields",
            "found \"friction\", which has no meaning without friction; give contact.friction above 0");
}

void require_rules(Reader& in, const Exact&, const Scene& scene) {
  for (const char* key : {"pressure", "impulse", "peak_force", "contact_start", "contact_time"})
    if (in.has(key) && scene.contacts.empty())
      in.fail(key, "has no meaning without contact; add a table [contact]");
}

namespace {

/// Default start of a search: coarse where possible. Guess if the control comes from an earlier run, which is
/// the better start; and for projected-gradient, since the paper starts that method from the first guess.
SearchStart usual_start(const Scene& scene) {
  return no_coarse_start(scene).empty() && !scene.control->stored &&
                 scene.optimizer.method != OptimizerMethod::projected_gradient
             ? SearchStart::coarse
             : SearchStart::guess;
}

} // namespace

void require_rules(Reader& in, Scene& scene, const Scene&) {
  if (scene.time.until_bounce)
    set_latest_end(in, scene);
  if (in.has("objective") && !scene.control)
    in.fail("objective", "needs a control; add a table [control], or remove the objective");
  require_fit_rules(in, scene);
  require_scenario_rules(in, scene);
  if (scene.time.automatic() && scene.control && scene.control->step) {
    // Else steps would pass intervals by, whose values no motion would depend on.
    constexpr double rounding = 1e-9;
    const double step = *scene.control->step;
    if (scene.time.longest.value_or(0) > (1 + rounding) * step)
      in.fail("time.longest", fmt::format("found {:.10g} s; expected at most control.step = {:.10g} s",
                                          *scene.time.longest, step));
    if (!scene.time.longest)
      scene.time.longest = std::min(step, scene.time.end / Time::usual_longest);
  }
  if (!scene.optimizer.tolerance && (scene.objective || !scene.unknowns.empty()))
    scene.optimizer.tolerance = scene.optimizer.method == OptimizerMethod::gauss_newton
                                    ? Optimizer::usual_of_fits
                                    : Optimizer::usual_tolerance;
  if (scene.objective) {
    if (!scene.optimizer.start)
      scene.optimizer.start = usual_start(scene);
    return;
  }
  if (in.has("check"))
    in.fail("check",
            "needs a control and an objective to differentiate; add [control] and [objective], or remove it");
  if (!scene.unknowns.empty())
    return;
  if (in.has("optimizer"))
    in.fail("optimizer", "has no effect without an objective; add [control] and [objective] or leave it out");
  if (in.has("trajectory"))
    in.fail("trajectory", "has no effect without an objective, since no adjoint sweep needs the states; add "
                          "[control] and [objective], or remove it");
}

} // namespace signorini::scene
