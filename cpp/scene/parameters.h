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

/// The limits that a parameter has by its nature.
Limits natural_limits(Parameter of);

constexpr bool of_material(Parameter of) { return of <= Parameter::density; }
constexpr bool of_obstacle(Parameter of) { return of >= Parameter::position && of <= Parameter::radius; }

/// The vector of which an unknown is a component or a multiple: an initial field, a centre.
Components components_of(const Scene& scene, const Unknown& unknown);

/// Numbers of the material and obstacle that an unknown is of. Throw std::out_of_range if the scene has none
/// such, which reading it excludes.
std::size_t material_of(const Scene& scene, const Unknown& unknown);
std::size_t contact_of(const Scene& scene, const Unknown& unknown);

/// The value that the scene itself has of an unknown; absent where that is an expression.
std::optional<double> own_value(const Scene& scene, const Unknown& unknown);

/// The values at which the unknowns start.
std::vector<double> start_values(const Scene& scene);

/// The scene with these values of its unknowns, in their order. Throws UserError if it can be none
/// (unknown_limits.h).
Scene with_values(Scene scene, std::span<const double> values);

/// How an obstacle changes with one of its parameters, per unit of it.
struct ObstacleRate {
  std::array<double, 3> point{};  ///< of the plane's point, the centre or the axis
  std::array<double, 3> normal{}; ///< of a half-space's unit normal
  double radius = 0;
};
/// With the unknown of this number, where the unknowns have these values; `scene` is as read.
ObstacleRate obstacle_rate(const Scene& scene, std::span<const double> values, std::size_t number);

/// The natural limits of an unknown; on a logarithmic scale it is positive.
Limits limits(const Unknown& unknown);
/// Throws UserError unless each unknown can have its value.
void require_possible(const Scene& scene, std::span<const double> values);

/// Whether a factor of tractions is one of this: it scales all on its group.
bool scales(const Unknown& unknown, const Traction& traction);

} // namespace signorini::scene
