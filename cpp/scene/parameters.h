// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include "scene/targets.h"
#include "scene/units.h"
#include <array>
#include <optional>
#include <span>
#include <string>

/// Values of a scene's unknowns and their effect on the scene; docs/method.md section 9.
namespace signorini::scene {

/// SI unit of an unknown of a scene whose mesh has `dim` dimensions; empty for a number without unit.
std::string unit(const Scene& scene, const Unknown& unknown, int dim);

/// Physical limits of a parameter, such as those of a density, which is positive.
Limits natural_limits(Parameter of);

constexpr bool of_material(Parameter of) { return of <= Parameter::density; }
constexpr bool of_branch(Parameter of) { return of >= Parameter::prony_g && of <= Parameter::prony_time; }
constexpr bool of_foundation(Parameter of) {
  return of >= Parameter::normal_stiffness && of <= Parameter::tangential_damping;
}
/// Whether a parameter belongs to the friction of an obstacle.
constexpr bool of_friction(Parameter of) {
  return of == Parameter::friction || of == Parameter::surface_velocity;
}
/// Whether a parameter belongs to the mass of an obstacle.
constexpr bool of_rigid_body(Parameter of) {
  return of >= Parameter::mass && of <= Parameter::dashpot_damping;
}
constexpr bool of_obstacle(Parameter of) {
  return (of >= Parameter::position && of <= Parameter::height) || of_friction(of) || of_rigid_body(of);
}

/// Components of the vector of an unknown, an initial field or a centre. The unknown is one of these
/// components or a factor on all of them.
Components components_of(const Scene& scene, const Unknown& unknown);

/// Value that the other tables of the scene give to an unknown, such as a density. It is 1 for a factor, and
/// 0 for the displacement or rotation of a plane. Absent if the tables give an expression of place or time.
std::optional<double> value_in_scene(const Scene& scene, const Unknown& unknown);

/// Start values of all unknowns, in the order of scene.unknowns.
std::vector<double> start_values(const Scene& scene);

/// Returns the scene with `values` (one for each unknown, in order) put into the tables that they belong to.
/// Throws UserError if a value is outside of its limits (require_possible()).
Scene with_values(Scene scene, std::span<const double> values);

/// Derivatives of an obstacle's geometry by one of its parameters, per unit of the parameter.
struct ObstacleRate {
  std::array<double, 3> point{};  ///< rate of the plane's point, the centre or the axis
  std::array<double, 3> normal{}; ///< rate of a half-space's unit normal
  double radius = 0;              ///< rate of a ball's or cylinder's radius
  double height = 0;              ///< rate of contact.height
};
/// Computes the derivatives of an obstacle's geometry by the unknown `number`, counted from 0, at `values` of
/// all unknowns. `scene`: as read, without these values.
ObstacleRate obstacle_rate(const Scene& scene, std::span<const double> values, std::size_t number);

/// Obstacles whose numbers are the derivatives of those of the obstacles with mass by an unknown, of
/// of_rigid_body(). Both are linear: all numbers are zero but that of the unknown, which is 1.
std::vector<Contact> rigid_body_rate(Scene scene, const Unknown& unknown);

/// Limits of an unknown: the physical limits of its parameter, and above 0 on a logarithmic scale.
Limits limits(const Unknown& unknown);
/// Describes the fractions of Prony series whose sum is too large at `values` of all unknowns, as the end of
/// a message; empty if none is.
std::string excess_of_fractions(const Scene& scene, std::span<const double> values);
/// Throws UserError unless each value is within the limits of its unknown, and the sums of fractions of Prony
/// series are below 1.
void require_possible(const Scene& scene, std::span<const double> values);

/// Whether an unknown factor of tractions multiplies `traction`. A factor with a group multiplies all
/// tractions on the group, a factor without one all tractions of the scene.
bool scales(const Unknown& unknown, const Traction& traction);

} // namespace signorini::scene
