// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include "scene/units.h"
#include <array>
#include <optional>
#include <span>
#include <string>

/// The unknowns of a scene as numbers of it; docs/method.md section 9.
namespace signorini::scene {

/// Unit of an unknown in SI; empty for a plain number.
std::string unit(const Unknown& unknown);

/// Limits of a parameter by its nature, such as a positive density.
Limits natural_limits(Parameter of);

constexpr bool of_material(Parameter of) { return of <= Parameter::density; }
constexpr bool of_obstacle(Parameter of) { return of >= Parameter::position && of <= Parameter::radius; }

/// Vector that an unknown is a component or a multiple of: an initial field, a centre.
Components components_of(const Scene& scene, const Unknown& unknown);

/// Numbers of the material and obstacle that an unknown belongs to. Throw std::out_of_range if the scene has
/// none, which reading it excludes.
std::size_t material_of(const Scene& scene, const Unknown& unknown);
std::size_t contact_of(const Scene& scene, const Unknown& unknown);

/// Value of an unknown in the scene itself; absent where that is an expression.
std::optional<double> own_value(const Scene& scene, const Unknown& unknown);

/// Start values of the unknowns.
std::vector<double> start_values(const Scene& scene);

/// Returns the scene with these values of its unknowns, in their order. Throws UserError if one is impossible
/// (require_possible()).
Scene with_values(Scene scene, std::span<const double> values);

/// Rates of change of an obstacle by one of its parameters, per unit of it.
struct ObstacleRate {
  std::array<double, 3> point{};  ///< rate of the plane's point, the centre or the axis
  std::array<double, 3> normal{}; ///< rate of a half-space's unit normal
  double radius = 0;
};
/// Returns the rates by the unknown of this number at these values of all unknowns; `scene` is as read.
ObstacleRate obstacle_rate(const Scene& scene, std::span<const double> values, std::size_t number);

/// Limits of an unknown: those of its parameter; positive on a logarithmic scale.
Limits limits(const Unknown& unknown);
/// Throws UserError unless each value is within the limits of its unknown.
void require_possible(const Scene& scene, std::span<const double> values);

/// Whether an unknown factor of tractions scales this one: it scales all on its group.
bool scales(const Unknown& unknown, const Traction& traction);

} // namespace signorini::scene
