// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/obstacle_forces.h"
#include <cmath>
#include <limits>

namespace signorini::diagnostics {
namespace {

/// The same but for the impulse so far.
void begin(ObstacleForce& one) {
  one = {.min_gap = std::numeric_limits<double>::infinity(), .impulse = one.impulse};
}

void add_impulse(ObstacleForce& one, double tau) {
  for (std::size_t c = 0; c < 3; ++c)
    one.impulse[c] += tau * one.force[c];
}

} // namespace

ObstacleForces::ObstacleForces(const step::Stepper& stepper)
    : stepper_(stepper),
      each_(stepper.pairs() ? static_cast<std::size_t>(stepper.pairs()->obstacle_count()) : 0) {}

void ObstacleForces::observe(const trajectory::Frame& frame) {
  begin(all_);
  for (ObstacleForce& one : each_)
    begin(one);
  if (each_.empty())
    return;
  const contact::ContactPairs& pairs = *stepper_.pairs();
  forces_.resize(frame.contact.lambda.size());
  std::ranges::transform(frame.contact.lambda, forces_.begin(),
                         [impulse = frame.step.scheme().impulse()](double force) { return force / impulse; });
  for (int i = 0; i < pairs.count(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    for (ObstacleForce* one : {&each_[static_cast<std::size_t>(pairs.obstacles()[at])], &all_}) {
      for (int c = 0; c < pairs.dim(); ++c) // on the body
        one->force[static_cast<std::size_t>(c)] -= pairs.force(pairs.rows(), i, c, forces_);
      one->normal_force += std::abs(forces_[at]);
      one->active += frame.contact.status[at] != contact::Status::open;
      one->min_gap = std::min(one->min_gap, frame.contact.gap[at]);
    }
  }
  const double tau = frame.step.tau;
  add_impulse(all_, tau);
  for (ObstacleForce& one : each_)
    add_impulse(one, tau);
}

bool LargestForce::observe(double force) {
  constexpr double rounding = 1e-9; // of a step's solution, relative
  if (!(force > (1 + rounding) * largest_))
    return false;
  largest_ = force;
  return true;
}

} // namespace signorini::diagnostics
