// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.h"
#include "base/overloads.h"
#include "base/text.h"
#include "scene/parameters.h"
#include "scene/rules.h"
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <optional>

namespace signorini::scene {

namespace {

/// Throws UserError if a `needed` key is missing, or if a key is given that is not `allowed`. `otherwise`:
/// message in the second case.
void require_where(Reader& in, const char* key, bool needed, bool allowed, const std::string& otherwise) {
  if (needed)
    in.require(key);
  else if (!allowed && in.has(key))
    in.fail(key, otherwise);
}

/// Throws UserError unless an obstacle has mass and the number of it that is unknown.
void require_rigid_parameter(Reader& in, const Unknown& unknown, const Contact& contact, const Scene& scene) {
  const std::string of = name(unknown.of);
  if (!contact.rigid)
    in.fail("of", fmt::format("found \"{}\" of an obstacle without mass; give obstacle.mass", of));
  RigidBody body = *contact.rigid;
  const std::vector<double>* numbers = numbers_of(body, unknown.of);
  if (numbers && numbers->empty())
    in.fail("of", fmt::format("found \"{0}\" of an obstacle without it; give obstacle.{0}", of));
  const bool several = numbers && numbers->size() > 1;
  require_where(in, "component", several, several,
                "has no effect on one number for all components; give one for each, or remove it");
  if (!several)
    return;
  if (static_cast<std::size_t>(*unknown.component) >= numbers->size())
    in.fail("component", fmt::format("found \"{}\", but obstacle.{} has {} components; choose one of these",
                                     name(*unknown.component), of, numbers->size()));
  if (unknown.of != Parameter::inertia && !body.moves_along(*unknown.component, scene.mesh.axisymmetric()))
    in.fail("component", fmt::format("found \"{}\", along which the obstacle does not move; choose another",
                                     name(*unknown.component)));
}

/// Throws UserError unless the obstacle of an unknown has the parameter that is unknown.
void require_obstacle_parameter(Reader& in, const Unknown& unknown, const Scene& scene) {
  const std::string of = name(unknown.of);
  if (scene.contacts.empty())
    in.fail("of", fmt::format("found \"{}\" in a scene without [contact]; add one", of));
  require_where(in, "obstacle", scene.contacts.size() > 1, true, "");
  if (unknown.obstacle)
    require_obstacle(in, *unknown.obstacle, scene);
  const Contact& contact = scene.contacts[contact_of(scene, unknown)];
  if (of_rigid_body(unknown.of))
    return require_rigid_parameter(in, unknown, contact, scene);
  if (of_friction(unknown.of) && !contact.frictional())
    in.fail("of", fmt::format("found \"{}\" of an obstacle without friction; give contact.friction", of));
  if (unknown.of == Parameter::surface_velocity && !contact.surface_velocity)
    in.fail("of", "found \"surface_velocity\" of an obstacle without one; give obstacle.surface_velocity");
  using Allowed = std::vector<std::string>;
  if (contact.against) {
    if (unknown.of != Parameter::height && !of_friction(unknown.of))
      in.fail("of", fmt::format("found \"{}\" of the contact of two parts; choices: height, friction", of));
    return;
  }
  Allowed allowed = std::visit(
      Overloads{[](const HalfSpace&) { return Allowed{name(Parameter::position), name(Parameter::angle)}; },
                [](const Ball&) { return Allowed{name(Parameter::center), name(Parameter::radius)}; },
                [](const Cylinder&) { return Allowed{name(Parameter::center), name(Parameter::radius)}; },
                [](const SignedDistance&) { return Allowed{}; }},
      *contact.obstacle);
  if (contact.frictional()) { // the tangents must stay
    const bool plane = std::holds_alternative<HalfSpace>(*contact.obstacle);
    allowed = plane ? Allowed{name(Parameter::position)} : Allowed{};
    allowed.emplace_back(name(Parameter::friction));
    allowed.emplace_back(name(Parameter::surface_velocity));
  }
  if (std::ranges::find(allowed, of) == allowed.end())
    in.fail("of", fmt::format("found \"{}\" of an obstacle of the shape \"{}\"{}; choices: {}", of,
                              name(static_cast<Shape>(contact.obstacle->index())),
                              contact.frictional() ? " with friction" : "",
                              allowed.empty() ? "other shapes" : list(allowed)));
  const bool round =
      std::holds_alternative<Ball>(*contact.obstacle) || std::holds_alternative<Cylinder>(*contact.obstacle);
  if (round && !of_friction(unknown.of) && moves(contact))
    in.fail("of", fmt::format("found \"{}\" of a round obstacle that moves; it must be at rest", of));
  const bool moves_center = unknown.of == Parameter::position || unknown.of == Parameter::center;
  if (moves_center && contact.rigid && !contact.rigid->inertia.empty() && contact.rigid->mass_center.empty())
    in.fail("of", fmt::format("found \"{}\" of an obstacle that turns about this point; give "
                              "obstacle.mass_center",
                              of));
  if (contact.initial == ContactStart::project && !of_friction(unknown.of))
    in.fail("of", fmt::format("found \"{}\" of an obstacle with initial = \"project\", with which the "
                              "initial positions of nodes would depend on the unknown; set initial to "
                              "\"outside\"",
                              of));
}

/// Throws UserError unless `material`, that of an unknown of a Prony series, has the branch of the unknown.
void require_branch(Reader& in, const Unknown& unknown, const Material& material) {
  const std::size_t count = material.prony.size();
  if (count == 0)
    in.fail("of", fmt::format("found \"{}\" of a material without prony; give the material a Prony series",
                              name(unknown.of)));
  require_where(in, "branch", count > 1, true, "");
  if (unknown.branch && static_cast<std::size_t>(*unknown.branch) >= count)
    in.fail("branch",
            fmt::format("found {}; expected {}, since the material has {} branch{}", *unknown.branch,
                        count == 1 ? "0" : fmt::format("0 to {}", count - 1), count, count == 1 ? "" : "es"));
}

/// Throws UserError unless the scene has the material, obstacle, field or load of the unknown.
void require_target(Reader& in, const Unknown& unknown, const Scene& scene) {
  const std::string of = name(unknown.of);
  const auto absent = [&](const char* what) {
    in.fail("of", fmt::format("found \"{}\" in a scene without {}; choose another parameter", of, what));
  };
  const auto one_of = [&](const std::vector<std::string>& groups, const char* single) {
    require_where(in, "on", groups.size() > 1, groups.size() > 1,
                  fmt::format("has no effect, since the scene has {}; remove it", single));
    if (unknown.on && std::ranges::find(groups, *unknown.on) == groups.end())
      in.fail("on", fmt::format("found \"{}\"; choices: {}", *unknown.on, list(groups)));
  };
  if (of_material(unknown.of)) {
    std::vector<std::string> groups;
    for (const Material& material : scene.materials)
      groups.push_back(material.on.value_or(""));
    one_of(groups, "one material only");
    if ((unknown.of == Parameter::bulk || unknown.of == Parameter::shear) &&
        !scene.materials[material_of(scene, unknown)].viscosity)
      in.fail("of", fmt::format("found \"{}\" of an elastic material; give the material a viscosity", of));
    if ((unknown.of == Parameter::alpha || unknown.of == Parameter::beta) &&
        !scene.materials[material_of(scene, unknown)].rayleigh)
      in.fail("of",
              fmt::format("found \"{}\" of a material without rayleigh; give the material this table", of));
    if (of_branch(unknown.of))
      require_branch(in, unknown, scene.materials[material_of(scene, unknown)]);
  } else if (of_foundation(unknown.of)) {
    std::vector<std::string> groups;
    for (const Foundation& foundation : scene.foundations)
      groups.push_back(foundation.on);
    if (groups.empty())
      absent("[[foundation]]");
    one_of(groups, "one foundation only");
    const Foundation& foundation = scene.foundations[foundation_of(scene, unknown)];
    const bool stiff =
        unknown.of == Parameter::normal_stiffness || unknown.of == Parameter::tangential_stiffness;
    if (!stiff && foundation.absorbing)
      in.fail("of",
              fmt::format("found \"{}\" of an absorbing foundation, whose dashpots follow from the material; "
                          "fit the material, or replace absorbing by damping",
                          of));
    if (stiff ? !foundation.stiffness : !foundation.damping)
      in.fail("of", fmt::format("found \"{}\" of a foundation without {}; give the foundation this table", of,
                                stiff ? "stiffness" : "damping"));
  } else if (of_obstacle(unknown.of)) {
    require_obstacle_parameter(in, unknown, scene);
  } else if (unknown.of == Parameter::velocity || unknown.of == Parameter::displacement) {
    const bool velocity = unknown.of == Parameter::velocity;
    if (velocity ? !scene.initial.velocity : !scene.initial.displacement)
      absent(velocity ? "initial.velocity" : "initial.displacement");
    const auto moved = [](const Contact& contact) { return contact.initial == ContactStart::project; };
    if (!velocity && std::ranges::any_of(scene.contacts, moved))
      in.fail("of", fmt::format("found \"{}\" with an obstacle that has initial = \"project\", which changes "
                                "the initial positions of nodes; set initial to \"outside\"",
                                of));
  } else if (!scene.load) {
    absent("[load]");
  } else if (unknown.of == Parameter::traction) {
    std::vector<std::string> groups;
    for (const Traction& traction : scene.load->tractions)
      if (std::ranges::find(groups, traction.on) == groups.end())
        groups.push_back(traction.on);
    if (groups.empty())
      absent("load.traction");
    one_of(groups, "tractions on one group only");
  } else if (unknown.of == Parameter::body ? !scene.load->body : !scene.load->gravity) {
    absent(of.c_str());
  }
}

/// Throws UserError, naming `key`, unless a value is within limits() of an unknown: the parameter's physical
/// limits, and above zero on a logarithmic scale.
void require_natural(const Reader& in, const char* key, double value, const Unknown& unknown) {
  if (const Limits possible = limits(unknown); !possible.contain(value))
    in.fail(key, fmt::format("found {:.10g}; expected a number{}", value, possible.range()));
}

/// Whether two unknowns of the same kind belong to the same material and branch, obstacle, group of tractions
/// or load.
bool same_target(const Scene& scene, const Unknown& a, const Unknown& b) {
  if (of_branch(a.of) && branch_of(scene, a) != branch_of(scene, b))
    return false;
  return of_material(a.of)     ? material_of(scene, a) == material_of(scene, b)
         : of_obstacle(a.of)   ? contact_of(scene, a) == contact_of(scene, b)
         : of_foundation(a.of) ? foundation_of(scene, a) == foundation_of(scene, b)
                               : a.on == b.on;
}

/// Throws UserError if an earlier unknown stands for the same number of the scene. A component of a field and
/// a factor of the whole field count as the same.
void require_another(const Reader& in, const Unknown& unknown, const Scene& scene) {
  for (std::size_t i = 0; i + 1 < scene.unknowns.size(); ++i) {
    const Unknown& other = scene.unknowns[i];
    const bool apart = unknown.component && other.component && *unknown.component != *other.component;
    if (other.of == unknown.of && !apart && same_target(scene, other, unknown))
      in.fail("of", fmt::format("found \"{}\", which {} fits too; remove one of them", name(unknown.of),
                                unknown_key(i)));
  }
}

/// Throws UserError unless the vector of an unknown has the unknown's component.
void require_component(const Reader& in, const Unknown& unknown, const Scene& scene) {
  if (!unknown.component || unknown.of == Parameter::angle || of_rigid_body(unknown.of))
    return;
  const std::size_t size = components_of(scene, unknown).size();
  if (static_cast<std::size_t>(*unknown.component) >= size)
    in.fail("component", fmt::format("found \"{}\", but the vector has {} components; choose one of these",
                                     name(*unknown.component), size));
}

/// Scale of an unknown whose table gives none: logarithmic for friction and for numbers of materials,
/// foundations and masses that have a unit, but not for velocities.
ParameterScale usual_scale(Parameter of) {
  const bool fraction = of == Parameter::poisson || of == Parameter::prony_g || of == Parameter::prony_k;
  return (of_material(of) && !fraction) || of_foundation(of) || of == Parameter::friction ||
                 (of_rigid_body(of) && of != Parameter::rigid_velocity)
             ? ParameterScale::logarithmic
             : ParameterScale::linear;
}

/// Throws UserError if the name of an unknown is also the name of a column of history.csv.
void require_free_name(const Reader& in, const std::string& name) {
  constexpr std::array columns{"iteration",      "objective",     "decrement",  "damping",  "forward_sweeps",
                               "adjoint_sweeps", "seconds",       "tracking",   "terminal", "control_cost",
                               "misfit",         "gradient_norm", "step_length"};
  if (std::ranges::find(columns, name) != columns.end())
    in.fail("name", fmt::format("found \"{}\", a column of history.csv; choose another name", name));
}

} // namespace

void require_rules(Reader& in, Unknown& unknown, const Scene& scene) {
  require_target(in, unknown, scene);
  if (scene.initial.equilibrium && !of_friction(unknown.of) && unknown.of != Parameter::velocity)
    in.fail("of",
            fmt::format("found \"{}\" with initial.static, whose equilibrium would depend on the unknown; "
                        "remove initial.static",
                        name(unknown.of)));
  using enum Parameter;
  const bool geometry = unknown.of >= position && unknown.of <= radius;
  if (scene.initial.drop && (geometry || unknown.of == gravity || unknown.of == displacement))
    in.fail("of", fmt::format("found \"{}\" with initial.drop, whose start would depend on the unknown; give "
                              "initial.velocity in place of the drop",
                              name(unknown.of)));
  require_model(in, unknown, scene);
  const bool in_place = unknown.of == Parameter::displacement || unknown.of == Parameter::velocity ||
                        unknown.of == Parameter::angle;
  if (!of_rigid_body(unknown.of))
    require_where(in, "component", unknown.of == Parameter::center,
                  in_place || unknown.of == Parameter::center,
                  "has no effect on an unknown without direction; remove it");
  if (!of_material(unknown.of) && !of_foundation(unknown.of) && unknown.of != Parameter::traction &&
      in.has("on"))
    in.fail("on", "has an effect only on materials, foundations and tractions; remove it");
  if (!of_obstacle(unknown.of) && in.has("obstacle"))
    in.fail("obstacle", "has an effect only on parameters of obstacles; remove it");
  if (!of_branch(unknown.of) && in.has("branch"))
    in.fail("branch", "has an effect only on parameters of a Prony series; remove it");
  std::string usual = name(unknown.of);
  if (unknown.component)
    usual += " " + name(*unknown.component);
  if (unknown.branch)
    usual += fmt::format(" {}", *unknown.branch);
  if (of_rigid_body(unknown.of)) // "velocity" alone might be the body's
    usual += " of " + scene.contacts[contact_of(scene, unknown)].name;
  else if (unknown.on || unknown.obstacle)
    usual += " of " + unknown.on.value_or(unknown.obstacle.value_or(""));
  unknown.name = unique_name(in, usual, scene.unknowns, "unknown");
  require_free_name(in, unknown.name);
  require_another(in, unknown, scene);
  if (!in.has("scale"))
    unknown.scale = usual_scale(unknown.of);
  require_component(in, unknown, scene);
  if (unknown.of == Parameter::spring_stiffness && !unknown.logarithmic() &&
      scene.contacts[contact_of(scene, unknown)].rigid->mass == 0)
    in.fail("scale",
            "found \"linear\" for the stiffness of an obstacle with mass 0, which must stay above 0; "
            "set it to \"log\"");
  if (!in.has("start")) {
    const std::optional<double> own = value_in_scene(scene, unknown);
    if (!own)
      in.require("start");
    unknown.start = *own;
  }
  require_natural(in, "start", unknown.start, unknown);
  if (unknown.lower)
    require_natural(in, "lower", *unknown.lower, unknown);
  if (unknown.upper)
    require_natural(in, "upper", *unknown.upper, unknown);
  if ((unknown.lower && !(*unknown.lower <= unknown.start)) ||
      (unknown.upper && !(unknown.start <= *unknown.upper)))
    in.fail("start", fmt::format("found {:.10g}; expected a number within the bounds", unknown.start));
  if (unknown.prior)
    require_natural(in, "prior", unknown.prior->mean, unknown);
}

void require_rules(Reader& in, Measurement& measurement, const Scene& scene) {
  measurement.name = unique_name(in, fmt::format("measurement {}", scene.measurements.size()),
                                 scene.measurements, "measurement");
  const bool motion = measurement.of == Quantity::displacement || measurement.of == Quantity::velocity;
  const std::string of = name(measurement.of);
  if (motion) {
    const std::ptrdiff_t given = in.has("point") + in.has("on") + in.has("obstacle");
    if (given != 1)
      in.fail("", fmt::format("found {}; give one of point, on, obstacle", given == 0 ? "none" : "several"));
    if (measurement.obstacle) {
      require_mass(in, *measurement.obstacle, scene);
      if (measurement.of == Quantity::velocity)
        require_inert(in, *measurement.obstacle, scene, "of");
    }
  } else {
    if (scene.contacts.empty())
      in.fail("of", fmt::format("found \"{}\" in a scene without [contact]; add one", of));
    for (const char* key : {"point", "on"})
      if (in.has(key))
        in.fail(key, "has no effect on quantities of contact; use it with a displacement or a velocity");
    if (measurement.obstacle)
      require_obstacle(in, *measurement.obstacle, scene);
  }
  require_where(in, "component", measurement.fitted(), measurement.fitted(),
                "has no effect on a quantity that is compared, but not fitted; remove it");
  require_where(in, "file", measurement.fitted(), measurement.fitted(),
                "has no effect on a quantity that is compared, but not fitted; use value");
  require_where(in, "value", !measurement.fitted(), !measurement.fitted(),
                "has no effect on a fitted quantity, whose values are in a file; remove it");
  require_where(in, "column", false, measurement.fitted(),
                "has no effect on a quantity without a file; remove it");
  require_where(in, "noise", false, measurement.fitted(),
                "has no effect on a quantity that is compared, but not fitted; use deviation");
  if (measurement.deviation && measurement.noise)
    in.fail("noise", "found together with deviation; give only one of them");
  require_model(in, measurement, scene);
}

std::string excess_of_fractions(const Scene& scene, std::span<const double> values) {
  std::vector<Material> materials = scene.materials;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (const Unknown& unknown = scene.unknowns[i]; of_branch(unknown.of))
      number_of(materials[material_of(scene, unknown)].prony.at(branch_of(scene, unknown)), unknown.of) =
          values[i];
  for (std::size_t i = 0; i < materials.size(); ++i)
    if (const std::string excess = excess_of_fractions(materials[i]); !excess.empty())
      return fmt::format("material{}.prony with {}", materials.size() == 1 ? "" : fmt::format("[{}]", i),
                         excess);
  return {};
}

void require_possible(const Scene& scene, std::span<const double> values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (const Limits possible = limits(scene.unknowns[i]); !possible.contain(values[i]))
      throw UserError(fmt::format("{}: the unknown \"{}\" is {:.10g}; expected a number{}",
                                  scene.file.string(), scene.unknowns[i].name, values[i], possible.range()));
  if (const std::string excess = excess_of_fractions(scene, values); !excess.empty())
    throw UserError(fmt::format("{}: the unknowns give {}", scene.file.string(), excess));
}

void require_fit_rules(Reader& in, Scene& scene) {
  if (scene.time.automatic() && !scene.measurements.empty())
    in.fail("measurement", "found with time.step = \"auto\", whose step lengths would change with the "
                           "unknowns and make the fit non-smooth; give time.step in s");
  if (!scene.unknowns.empty()) {
    // Unknowns are sought together with a control, by lbfgs.
    const OptimizerMethod method = scene.objective ? OptimizerMethod::lbfgs : OptimizerMethod::gauss_newton;
    if (in.has("optimizer") && in.table("optimizer").has("method") && scene.optimizer.method != method)
      in.fail("optimizer.method", fmt::format("found \"{}\" with tables [[unknown]]{}; set it to \"{}\"",
                                              name(scene.optimizer.method),
                                              scene.objective ? " and a control" : "", name(method)));
    scene.optimizer.method = method;
    if (const std::string excess = excess_of_fractions(scene, start_values(scene)); !excess.empty())
      in.fail("unknown", "found start values of " + excess);
    if (!scene.objective && in.has("optimizer"))
      for (const char* key : {"start", "checkpoint", "memory"})
        if (Reader optimizer = in.table("optimizer"); optimizer.has(key))
          optimizer.fail(key, "has no effect on a fit without a control; remove it");
  } else if (scene.optimizer.method == OptimizerMethod::gauss_newton) {
    in.fail("optimizer.method", "found \"gauss-newton\" without unknowns; add tables [[unknown]]");
  }
  if (!scene.unknowns.empty() && std::ranges::none_of(scene.measurements, &Measurement::fitted))
    in.fail("unknown", "needs data to fit; add a table [[measurement]] of a motion, force or impulse, or "
                       "remove the unknowns");
}

} // namespace signorini::scene
