// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/drop.h"
#include "scene/expression.h"
#include <array>
#include <cmath>

namespace signorini::scene {

Fall fall(const Scene& scene) {
  return fall(scene.load.value().gravity.value(), scene.initial.drop.value().height);
}

Fall fall(const Components& gravity, double height) {
  Fall fall;
  fall.direction.resize(gravity.size());
  const std::array<double, 3> origin{};
  Field(gravity, "load.gravity", true).evaluate(origin.data(), 0, fall.direction.data());
  double squares = 0;
  for (const double component : fall.direction)
    squares += component * component;
  fall.acceleration = std::sqrt(squares);
  for (double& component : fall.direction)
    component /= fall.acceleration;
  fall.speed = std::sqrt(2 * fall.acceleration * height);
  return fall;
}

} // namespace signorini::scene
