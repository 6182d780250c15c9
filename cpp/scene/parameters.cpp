// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/parameters.h"
#include "base/error.h"
#include "base/overloads.h"
#include "scene/expression.h"
#include "scene/reader.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace signorini::scene {
namespace {

using Vector = std::array<double, 3>;

Vector unit_vector(const std::vector<double>& x) {
  Vector u{};
  double length = 0;
  for (double c : x)
    length = std::hypot(length, c);
  for (std::size_t c = 0; c < x.size(); ++c)
    u[c] = x[c] / length;
  return u;
}

/// Unit vector of the axis about which an unknown angle turns a plane; in 2D the z axis.
Vector axis(const Unknown& unknown) {
  Vector a{};
  a[static_cast<std::size_t>(unknown.component.value_or(Component::z))] = 1;
  return a;
}

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Rotates x about the unit vector `about` by an angle (rad), by Rodrigues' formula.
Vector turned(const Vector& x, const Vector& about, double angle) {
  const Vector across = cross(about, x);
  const double along = about[0] * x[0] + about[1] * x[1] + about[2] * x[2];
  Vector y{};
  for (std::size_t c = 0; c < 3; ++c)
    y[c] = std::cos(angle) * x[c] + std::sin(angle) * across[c] + (1 - std::cos(angle)) * along * about[c];
  return y;
}

std::optional<double> constant(const Expression& expression) {
  const Field field({expression}, "unknown", true);
  if (field.depends_on_time() || field.depends_on_place())
    return std::nullopt;
  const Vector origin{};
  double value = 0;
  field.evaluate(origin.data(), 0, &value);
  return value;
}

/// Initial displacement or velocity, whichever an unknown is a component or a factor of.
std::optional<Components>& initial_field(Initial& initial, const Unknown& unknown) {
  return unknown.of == Parameter::velocity ? initial.velocity : initial.displacement;
}

std::size_t component(const Unknown& unknown) { return static_cast<std::size_t>(unknown.component.value()); }

/// References to centre and radius of a ball or cylinder; the centre of a cylinder is a point of its axis.
struct Round {
  Components& center;
  Expression& radius;
};

/// References to centre and radius of a ball or cylinder. Throws std::logic_error for other shapes, which
/// reading a scene excludes.
Round round_parts(Obstacle& shape) {
  return std::visit(
      Overloads{[](Ball& ball) -> Round { return {ball.center, ball.radius}; },
                [](Cylinder& cylinder) -> Round { return {cylinder.point, cylinder.radius}; },
                [](HalfSpace&) -> Round { throw std::logic_error("a plane has no centre"); },
                [](SignedDistance&) -> Round { throw std::logic_error("a level set has no centre"); }},
      shape);
}

void multiply(Components& components, double factor) {
  for (Expression& expression : components) {
    expression.factor *= factor;
    expression.shift *= factor;
  }
}

void set(Scene& scene, const Unknown& unknown, double value) {
  switch (unknown.of) {
  case Parameter::young:
  case Parameter::poisson:
  case Parameter::bulk:
  case Parameter::shear:
  case Parameter::alpha:
  case Parameter::beta:
  case Parameter::prony_g:
  case Parameter::prony_k:
  case Parameter::prony_time:
  case Parameter::density:
  case Parameter::normal_stiffness:
  case Parameter::tangential_stiffness:
  case Parameter::normal_damping:
  case Parameter::tangential_damping:
  case Parameter::mass:
  case Parameter::inertia:
  case Parameter::rigid_velocity:
  case Parameter::spring_stiffness:
  case Parameter::dashpot_damping:
  case Parameter::height:
    number_of(scene, unknown) = value;
    return;
  case Parameter::displacement:
  case Parameter::velocity: {
    Components& field = initial_field(scene.initial, unknown).value();
    if (unknown.component)
      field.at(component(unknown)) = Expression(value);
    else
      multiply(field, value);
    return;
  }
  case Parameter::position: {
    auto& plane = std::get<HalfSpace>(*scene.contacts[contact_of(scene, unknown)].obstacle);
    const Vector out = unit_vector(plane.normal);
    for (std::size_t c = 0; c < plane.point.size(); ++c)
      plane.point[c].shift += value * out[c];
    return;
  }
  case Parameter::angle: {
    auto& plane = std::get<HalfSpace>(*scene.contacts[contact_of(scene, unknown)].obstacle);
    const Vector normal = turned(unit_vector(plane.normal), axis(unknown), value);
    plane.normal.assign(normal.begin(), normal.begin() + static_cast<std::ptrdiff_t>(plane.normal.size()));
    return;
  }
  case Parameter::center:
    round_parts(*scene.contacts[contact_of(scene, unknown)].obstacle).center.at(component(unknown)) =
        Expression(value);
    return;
  case Parameter::radius:
    round_parts(*scene.contacts[contact_of(scene, unknown)].obstacle).radius = Expression(value);
    return;
  case Parameter::friction: {
    Contact& contact = scene.contacts[contact_of(scene, unknown)];
    (contact.bound ? contact.bound->traction : contact.friction) = Expression(value);
    return;
  }
  case Parameter::surface_velocity:
    multiply(scene.contacts[contact_of(scene, unknown)].surface_velocity.value(), value);
    return;
  case Parameter::body:
    multiply(scene.load.value().body.value(), value);
    return;
  case Parameter::gravity:
    multiply(scene.load.value().gravity.value(), value);
    return;
  case Parameter::traction:
    for (Traction& traction : scene.load.value().tractions)
      if (scales(unknown, traction))
        multiply(traction.value, value);
  }
}

} // namespace

std::string unit(const Scene& scene, const Unknown& unknown, int dim) {
  const std::string per_depth = scene.mesh.per_depth(dim);
  switch (unknown.of) {
  case Parameter::young:
    return "Pa";
  case Parameter::bulk:
  case Parameter::shear:
    return "Pa s";
  case Parameter::alpha:
    return "1/s";
  case Parameter::beta:
  case Parameter::prony_time:
    return "s";
  case Parameter::normal_stiffness:
  case Parameter::tangential_stiffness:
    return "N/m³";
  case Parameter::normal_damping:
  case Parameter::tangential_damping:
    return "N s/m³";
  case Parameter::density:
    return "kg/m³";
  case Parameter::displacement:
    return unknown.component ? "m" : "";
  case Parameter::velocity:
    return unknown.component ? "m/s" : "";
  case Parameter::position:
  case Parameter::center:
  case Parameter::radius:
  case Parameter::height:
    return "m";
  case Parameter::angle:
    return "rad";
  case Parameter::friction:
    return scene.contacts[contact_of(scene, unknown)].bound ? "Pa" : "";
  case Parameter::rigid_velocity:
    return "m/s";
  case Parameter::mass:
    return "kg" + per_depth;
  case Parameter::inertia:
    return "kg m²" + per_depth;
  case Parameter::spring_stiffness:
    return "N/m" + per_depth;
  case Parameter::dashpot_damping:
    return "N s/m" + per_depth;
  case Parameter::poisson:
  case Parameter::prony_g:
  case Parameter::prony_k:
  case Parameter::surface_velocity:
  case Parameter::body:
  case Parameter::gravity:
  case Parameter::traction:
    break;
  }
  return "";
}

bool scales(const Unknown& unknown, const Traction& traction) {
  return !unknown.on || traction.on == *unknown.on;
}

Limits natural_limits(Parameter of) {
  switch (of) {
  case Parameter::young:
  case Parameter::density:
  case Parameter::radius:
  case Parameter::prony_time:
  case Parameter::friction: // without friction the step has other equations
  case Parameter::mass:
  case Parameter::inertia:
    return {.least = 0, .open = true};
  case Parameter::prony_g:
  case Parameter::prony_k:
    return {.least = 0, .greatest = 1};
  case Parameter::bulk:
  case Parameter::shear:
  case Parameter::alpha:
  case Parameter::beta:
  case Parameter::normal_stiffness:
  case Parameter::tangential_stiffness:
  case Parameter::normal_damping:
  case Parameter::tangential_damping:
  case Parameter::spring_stiffness:
  case Parameter::dashpot_damping:
    return {.least = 0};
  case Parameter::poisson:
    return {.least = -1, .greatest = 0.5, .open = true};
  default:
    return {};
  }
}

Components components_of(const Scene& scene, const Unknown& unknown) {
  if (unknown.of == Parameter::center) {
    Obstacle shape = *scene.contacts[contact_of(scene, unknown)].obstacle;
    return round_parts(shape).center;
  }
  Initial initial = scene.initial;
  return initial_field(initial, unknown).value();
}

std::optional<double> value_in_scene(const Scene& scene, const Unknown& unknown) {
  switch (unknown.of) {
  case Parameter::young:
  case Parameter::poisson:
  case Parameter::bulk:
  case Parameter::shear:
  case Parameter::alpha:
  case Parameter::beta:
  case Parameter::prony_g:
  case Parameter::prony_k:
  case Parameter::prony_time:
  case Parameter::density:
  case Parameter::normal_stiffness:
  case Parameter::tangential_stiffness:
  case Parameter::normal_damping:
  case Parameter::tangential_damping:
  case Parameter::mass:
  case Parameter::inertia:
  case Parameter::rigid_velocity:
  case Parameter::spring_stiffness:
  case Parameter::dashpot_damping:
  case Parameter::height: {
    Scene copy = scene;
    return number_of(copy, unknown);
  }
  case Parameter::displacement:
  case Parameter::velocity:
    return unknown.component ? constant(components_of(scene, unknown).at(component(unknown))) : 1;
  case Parameter::position:
  case Parameter::angle:
    return 0;
  case Parameter::center:
    return constant(components_of(scene, unknown).at(component(unknown)));
  case Parameter::radius: {
    Obstacle shape = *scene.contacts[contact_of(scene, unknown)].obstacle;
    return constant(round_parts(shape).radius);
  }
  case Parameter::friction: {
    const Contact& contact = scene.contacts[contact_of(scene, unknown)];
    return constant(contact.bound ? contact.bound->traction : contact.friction);
  }
  case Parameter::surface_velocity:
  case Parameter::body:
  case Parameter::gravity:
  case Parameter::traction:
    break;
  }
  return 1;
}

std::vector<double> start_values(const Scene& scene) {
  std::vector<double> values;
  for (const Unknown& unknown : scene.unknowns)
    values.push_back(unknown.start);
  return values;
}

Limits limits(const Unknown& unknown) {
  Limits limits = natural_limits(unknown.of);
  if (unknown.logarithmic() && !(limits.least > 0)) {
    limits.least = 0;
    limits.open = true;
  }
  return limits;
}

Scene with_values(Scene scene, std::span<const double> values) {
  require_possible(scene, values);
  const std::vector<Unknown> unknowns = scene.unknowns;
  // Positions are along the normals that the scene has, before any of them turns.
  for (const bool turns : {false, true})
    for (std::size_t i = 0; i < unknowns.size(); ++i)
      if ((unknowns[i].of == Parameter::angle) == turns)
        set(scene, unknowns[i], values[i]);
  return scene;
}

std::vector<Contact> rigid_body_rate(Scene scene, const Unknown& unknown) {
  for (Contact& contact : scene.contacts)
    if (std::optional<RigidBody>& body = contact.rigid) {
      body->mass = 0;
      body->force.reset();
      for (std::vector<double>* numbers : {&body->velocity, &body->inertia, &body->stiffness, &body->damping})
        std::ranges::fill(*numbers, 0);
    }
  number_of(scene, unknown) = 1;
  return scene.contacts;
}

ObstacleRate obstacle_rate(const Scene& scene, std::span<const double> values, std::size_t number) {
  const Unknown& unknown = scene.unknowns.at(number);
  const std::size_t contact = contact_of(scene, unknown);
  ObstacleRate rate;
  if (unknown.of == Parameter::center)
    rate.point[component(unknown)] = 1;
  if (unknown.of == Parameter::radius)
    rate.radius = 1;
  if (unknown.of == Parameter::height)
    rate.height = 1;
  const auto& shape = scene.contacts[contact].obstacle;
  const auto* plane = shape ? std::get_if<HalfSpace>(&*shape) : nullptr;
  if (!plane)
    return rate;
  Vector normal = unit_vector(plane->normal);
  if (unknown.of == Parameter::position)
    rate.point = normal;
  for (std::size_t i = 0; i < scene.unknowns.size(); ++i) { // in the order of with_values()
    const Unknown& other = scene.unknowns[i];
    if (other.of != Parameter::angle || contact_of(scene, other) != contact)
      continue;
    normal = turned(normal, axis(other), values[i]);
    rate.normal = i == number ? cross(axis(other), normal) : turned(rate.normal, axis(other), values[i]);
  }
  return rate;
}

} // namespace signorini::scene
