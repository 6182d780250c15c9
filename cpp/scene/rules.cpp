// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/rules.h"
#include "base/error.h"
#include "base/overloads.h"
#include "base/text.h"
#include "scene/expression.h"
#include "scene/key_reference.h"
#include "scene/targets.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

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

namespace {

/// Checks that the vectors of a scene have as many components as the mesh has dimensions.
class Dimension {
public:
  Dimension(const Scene& scene, int dim) : scene_(scene), dim_(dim) {}

  void vector(std::size_t size, const std::string& key, bool one_allowed = false) const {
    if (size != static_cast<std::size_t>(dim_) && !(one_allowed && size == 1))
      throw UserError(fmt::format("{}: found {} components; expected {}, since the mesh is {}-dimensional",
                                  where(key), size, dim_, dim_));
  }
  template <class V>
  void vector(const std::optional<V>& given, const std::string& key, bool one_allowed = false) const {
    if (given)
      vector(given->size(), key, one_allowed);
  }
  void acting(const std::optional<std::vector<Component>>& given, const std::string& key) const {
    std::vector<std::string> allowed = all_names<Component>();
    allowed.resize(static_cast<std::size_t>(dim_));
    for (Component component : given.value_or(components(dim_)))
      if (static_cast<int>(component) >= dim_)
        throw UserError(fmt::format("{}: found \"{}\"; choices: {}, since the mesh is {}-dimensional",
                                    where(key), name(component), list(allowed), dim_));
  }
  /// Checks that an axis of rotation is given in 3D and absent in 2D, where it can only be z.
  void axis(const std::optional<Component>& given, const std::string& key) const {
    if (given.has_value() == (dim_ == 2))
      throw UserError(fmt::format("{}: found {}; expected {}, since the mesh is {}-dimensional", where(key),
                                  given ? name(*given) : "none",
                                  dim_ == 2 ? "none (the angle is in the plane)" : "an axis", dim_));
  }
  void plane_model() const {
    if (scene_.mesh.model && dim_ != 2)
      throw UserError(
          fmt::format("{}: found \"{}\" with a mesh in space; it applies to meshes in the plane, so "
                      "remove it",
                      where("mesh.model"), name(*scene_.mesh.model)));
  }
  void obstacle(const Obstacle& shape, const std::string& key) const {
    std::visit(Overloads{[&](const HalfSpace& plane) {
                           vector(plane.point.size(), key + "point");
                           vector(plane.normal.size(), key + "normal");
                         },
                         [&](const Ball& ball) { vector(ball.center.size(), key + "center"); },
                         [&](const Cylinder& cylinder) { vector(cylinder.point.size(), key + "point"); },
                         [](const SignedDistance&) {}}, // its expression has x, y, z in any dimension
               shape);
  }

  void rigid_body(const RigidBody& body, const std::string& key) const {
    const auto given = [&](const std::vector<double>& values, const char* name, bool one_allowed) {
      if (!values.empty())
        vector(values.size(), key + name, one_allowed);
    };
    given(body.velocity, "velocity", false);
    given(body.mass_center, "mass_center", false);
    given(body.stiffness, "stiffness", true);
    given(body.damping, "damping", true);
    vector(body.force, key + "force");
    acting(body.components, key + "components");
    const std::size_t turns = dim_ == 2 ? 1 : 3;
    if (!body.inertia.empty() && body.inertia.size() != turns)
      throw UserError(fmt::format("{}: found {} numbers; expected {}, since the mesh is {}-dimensional",
                                  where(key + "inertia"), body.inertia.size(), turns, dim_));
  }

private:
  /// Key, preceded by "--set" or by the name of the scene file, whichever gave the key.
  [[nodiscard]] std::string where(const std::string& key) const {
    const std::string plain = without_numbers(key);
    const auto gave = [&](const std::string& set) { return plain == set || plain.starts_with(set + "."); };
    return (std::ranges::any_of(scene_.given, gave) ? "--set " : scene_.file.string() + ": ") + key;
  }

  const Scene& scene_;
  int dim_;
};

} // namespace

void require_dimension(const Scene& scene, int dim) {
  const Dimension require(scene, dim);
  require.plane_model();
  for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
    const std::string key = contact_key(scene.contacts, i) + ".obstacle.";
    if (const auto& shape = scene.contacts[i].obstacle)
      require.obstacle(*shape, key);
    require.vector(scene.contacts[i].surface_velocity, key + "surface_velocity");
    if (const auto& body = scene.contacts[i].rigid)
      require.rigid_body(*body, key);
  }
  for (std::size_t i = 0; i < scene.clamps.size(); ++i) {
    const Clamp& clamp = scene.clamps[i];
    require.acting(clamp.components, clamp_key(scene.clamps, i) + ".components");
    if (!clamp.components)
      require.vector(clamp.value, clamp_key(scene.clamps, i) + ".value");
  }
  if (scene.load) {
    require.vector(scene.load->body, "load.body");
    require.vector(scene.load->gravity, "load.gravity");
  }
  for (std::size_t i = 0; scene.load && i < scene.load->tractions.size(); ++i)
    require.vector(scene.load->tractions[i].value.size(), fmt::format("load.traction[{}].value", i));
  for (std::size_t i = 0; scene.load && i < scene.load->points.size(); ++i) {
    require.vector(scene.load->points[i].at.size(), fmt::format("load.point[{}].at", i));
    require.vector(scene.load->points[i].value.size(), fmt::format("load.point[{}].value", i));
  }
  require.vector(scene.initial.displacement, "initial.displacement");
  require.vector(scene.initial.velocity, "initial.velocity");
  if (const auto& control = scene.control) {
    require.acting(control->components, "control.components");
    require.vector(control->initial, "control.initial");
    require.vector(control->lower, "control.lower", true);
    require.vector(control->upper, "control.upper", true);
  }
  if (scene.objective) {
    if (const auto* desired = std::get_if<DesiredControl>(&scene.objective->desired))
      require.vector(desired->control.size(), "objective.desired.control");
    if (const auto* desired = std::get_if<DesiredDisplacement>(&scene.objective->desired))
      require.vector(desired->displacement.size(), "objective.desired.displacement");
  }
  require.vector(scene.check.control, "check.control");
  for (std::size_t i = 0; i < scene.output.probes.size(); ++i)
    require.vector(scene.output.probes[i].point, fmt::format("output.probe[{}].point", i));
  for (std::size_t i = 0; i < scene.unknowns.size(); ++i) {
    const Unknown& unknown = scene.unknowns[i];
    const std::string key = unknown_key(i) + ".component";
    if (unknown.of == Parameter::angle)
      require.axis(unknown.component, key);
    else if (unknown.component)
      require.acting(std::vector{*unknown.component}, key);
  }
  for (std::size_t i = 0; i < scene.measurements.size(); ++i) {
    require.vector(scene.measurements[i].point, measurement_key(i) + ".point");
    if (const auto component = scene.measurements[i].component)
      require.acting(std::vector{*component}, measurement_key(i) + ".component");
  }
  if (scene.exact)
    require.vector(scene.exact->displacement, "exact.displacement");
}

} // namespace signorini::scene
