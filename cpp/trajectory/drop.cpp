// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/drop.h"
#include "base/error.h"
#include "contact/pairs.h"
#include "scene/drop.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace signorini::trajectory {
using petsc::check;

void drop(const step::Stepper& stepper, const scene::Scene& scene, Vec y, Vec v) {
  const scene::Fall fall = scene::fall(scene);
  const fem::Space& space = stepper.space();
  const petsc::Vector direction = space.vector();
  {
    const petsc::WriteArray values(direction);
    for (std::size_t i = 0; i < space.layout().mesh_dofs(); ++i)
      values[i] = fall.direction[i % fall.direction.size()];
  }
  stepper.clamped().clear(direction); // radial dofs on the axis of a body of revolution
  const contact::ContactPairs& pairs = *stepper.pairs();
  std::vector<double> gap(static_cast<std::size_t>(pairs.rows().count())), nearer(gap.size());
  pairs.rows().gap(pairs.psi(), y, gap);
  pairs.rows().apply_transpose(direction, nearer);
  constexpr double rounding = 1e-9; // of the cosine between normal and gravity
  double way = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < static_cast<std::size_t>(pairs.count()); ++i)
    if (nearer[i] > rounding)
      way = std::min(way, gap[i] / nearer[i]);
  if (!std::isfinite(way))
    throw UserError("initial.drop: no node of contact.on is above an obstacle along load.gravity; turn the "
                    "obstacle's normal or gravity");
  check(VecAXPY(y, way, direction));
  if (pairs.skips_axis()) // a vertex on the axis that is no candidate, but must not be inside
    check(VecAXPY(y, -pairs.deepest_on_axis(y, 0).depth, direction));
  check(VecAXPY(v, fall.speed, direction));
}

bool touches_again(const step::Stepper& stepper, const fem::RigidMotions& rigid, const Frame& frame,
                   double until) {
  const contact::ContactPairs& pairs = *stepper.pairs();
  const petsc::Vector rest = petsc::copy(frame.after.v()); // the velocity without its rigid part
  rigid.subtract(rigid.coefficients(frame.after.v()), rest);
  {
    const petsc::WriteArray values(rest); // obstacles with mass move as they do
    for (std::size_t i = stepper.space().layout().mesh_dofs(); i < values.size(); ++i)
      values[i] = 0;
  }
  const petsc::Vector moves = petsc::copy(frame.after.v());
  check(VecAXPY(moves, -1, rest));
  std::vector<double> nearer(static_cast<std::size_t>(pairs.rows().count()));
  pairs.rows().apply_transpose(moves, nearer);
  for (std::size_t i = 0; i < static_cast<std::size_t>(pairs.count()); ++i)
    if (nearer[i] * (until - frame.step.end) > frame.contact.gap[i])
      return true;
  return false;
}

} // namespace signorini::trajectory
