// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/approach.h"
#include "base/overloads.h"
#include "trajectory/first_touch.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace signorini::trajectory {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// The fields by which an obstacle moves.
std::vector<scene::Field> fields_of(const scene::Obstacle& obstacle) {
  std::vector<scene::Field> fields;
  const auto add = [&](const scene::Components& components) {
    fields.emplace_back(components, "contact.obstacle", true);
  };
  std::visit(Overloads{[&](const scene::HalfSpace& plane) { add(plane.point); },
                       [&](const scene::Ball& ball) { add(ball.center), add({ball.radius}); },
                       [&](const scene::Cylinder& cylinder) { add(cylinder.point), add({cylinder.radius}); },
                       [&](const scene::SignedDistance& level_set) { add({level_set.distance}); }},
             obstacle);
  std::erase_if(fields, [](const scene::Field& field) { return !field.depends_on_time(); });
  return fields;
}

} // namespace

Approach::Approach(const step::Stepper& stepper, const scene::Scene& scene, const StepErrors& errors)
    : stepper_(stepper), errors_(errors), points_(scene.contacts.size()), obstacles_(scene.contacts.size()),
      clamped_(scene.clamps.size()) {
  const fem::Space& space = stepper.space();
  const double end = stepper.end();
  if (const contact::ContactPairs* pairs = stepper.pairs())
    for (std::size_t i = 0; i < pairs->psi().size(); ++i) {
      std::vector<double>& points = points_[static_cast<std::size_t>(pairs->obstacles()[i])];
      points.insert(points.end(), &pairs->points()[3 * i], &pairs->points()[3 * i] + 3);
      free_ = free_ && !held(i);
    }
  for (std::size_t o = 0; o < obstacles_.size(); ++o)
    for (scene::Field& field : fields_of(scene.contacts[o].obstacle)) // candidates are on every rank
      obstacles_[o].push_back(
          std::make_unique<fem::TimeProfile>(MPI_COMM_SELF, std::move(field), points_[o], end));
  for (std::size_t c = 0; c < scene.clamps.size(); ++c) {
    if (!scene.clamps[c].value)
      continue;
    const std::string key = scene::clamp_key(scene.clamps, c);
    for (const int node : space.nodes_on(scene.clamps[c].on, key + ".on"))
      clamped_[c].insert(clamped_[c].end(), &space.points()[3 * static_cast<std::size_t>(node)],
                         &space.points()[3 * static_cast<std::size_t>(node)] + 3);
    scene::Field field(*scene.clamps[c].value, key + ".value", true);
    if (field.depends_on_time())
      clamps_.push_back(std::make_unique<fem::TimeProfile>(space.comm(), std::move(field), clamped_[c], end));
  }
}

bool Approach::held(std::size_t candidate) const {
  const std::size_t k = errors_.rigid().count();
  const auto first = errors_.normal_motions().begin() + static_cast<std::ptrdiff_t>(candidate * k);
  return std::all_of(first, first + static_cast<std::ptrdiff_t>(k), [](double x) { return x == 0; });
}

Approach::Along Approach::along(std::size_t candidate) const {
  const StepErrors::RigidState& now = errors_.rigid_state();
  const std::size_t k = errors_.rigid().count();
  Along sum;
  for (std::size_t j = 0; j < k; ++j) {
    const double factor = errors_.normal_motions()[candidate * k + j];
    sum.position += factor * now.position[j];
    sum.velocity += factor * now.velocity[j];
    sum.acceleration += factor * now.acceleration[j];
  }
  return sum;
}

double Approach::until_touch(double t) const {
  const contact::ContactPairs* pairs = stepper_.pairs();
  double least = never;
  if (!pairs)
    return least;
  for (std::size_t i = 0; i < pairs->psi().size(); ++i) {
    const auto o = static_cast<std::size_t>(pairs->obstacles()[i]);
    if (!obstacles_[o].empty() || errors_.contact(o) || held(i))
      continue;
    const Along body = along(i);
    // Either farther than the vibration reaches, or by the gap itself, at no more than twice that swings.
    const double beyond = first_root(pairs->psi()[i] - body.position - errors_.reach(o), -body.velocity,
                                     -body.acceleration),
                 by_gap = first_root(errors_.gaps()[i], -std::max(body.velocity, 0.0) - 2 * errors_.swing(o),
                                     -std::max(body.acceleration, 0.0));
    least = std::min(least, std::max(beyond, by_gap));
  }
  for (std::size_t o = 0; o < obstacles_.size(); ++o)
    if (!obstacles_[o].empty() && !errors_.contact(o))
      least = std::min(least, until_moving(o, t));
  return t + least < stepper_.end() ? least : never;
}

double Approach::until_moving(std::size_t obstacle, double t) const {
  const contact::ContactPairs& pairs = *stepper_.pairs();
  std::vector<std::size_t> candidates;
  for (std::size_t i = 0; i < pairs.psi().size(); ++i)
    if (pairs.obstacles()[i] == static_cast<int>(obstacle))
      candidates.push_back(i);
  const contact::Obstacle& shape = pairs.obstacle(static_cast<int>(candidates.front()));
  const auto within_reach = [&](std::size_t i, const contact::Obstacle::Place& place) {
    const Along body = along(i);
    const double s = place.t - t, moved = body.position + s * body.velocity + s * s / 2 * body.acceleration;
    return shape.at(&pairs.points()[3 * i], place).height - moved <= errors_.reach(obstacle);
  };
  const auto touches = [&](double at) {
    const contact::Obstacle::Place place = shape.place(at);
    return std::ranges::any_of(candidates, [&](std::size_t i) { return within_reach(i, place); });
  };
  // Candidates that clamps hold within reach swing there, and say nothing of the obstacle.
  std::erase_if(candidates,
                [&, place = shape.place(t)](std::size_t i) { return held(i) && within_reach(i, place); });
  if (touches(t))
    return 0;
  // Farther and farther, so that what is near is looked at closely.
  double from = t;
  for (double length = stepper_.step_lengths()->shortest_step(); from < stepper_.end(); length *= 2) {
    const double to = std::min(from + length, stepper_.end());
    for (const std::unique_ptr<fem::TimeProfile>& profile : obstacles_[obstacle])
      if (std::ranges::any_of(profile->times(from, to), touches))
        return from - t;
    if (touches(to))
      return from - t;
    from = to;
  }
  return never;
}

bool Approach::smooth(double from, double to, double deep, double part) const {
  for (std::size_t o = 0; o < obstacles_.size(); ++o)
    for (const std::unique_ptr<fem::TimeProfile>& profile : obstacles_[o])
      if (errors_.contact(o) && profile->deviation(from, to) > deep)
        return false;
  return std::ranges::all_of(clamps_, [&](const std::unique_ptr<fem::TimeProfile>& profile) {
    return profile->deviation(from, to) <= part * profile->range();
  });
}

} // namespace signorini::trajectory
