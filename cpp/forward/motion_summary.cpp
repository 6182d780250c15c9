#include "forward/motion_summary.h"
#include <algorithm>
#include <cmath>
#include <numeric>

namespace signorini::forward {
using petsc::check;

namespace {

double length(const std::array<double, 3>& x) { return std::hypot(x[0], x[1], x[2]); }

double product(const std::array<double, 3>& x, const std::array<double, 3>& y) {
  return std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
}

std::array<double, 3> over(std::array<double, 3> x, double divisor) {
  for (double& component : x)
    component /= divisor;
  return x;
}

/// e·Me for a translation e along one axis. Collective.
double mass(const Stepper& stepper) {
  const petsc::Vector e = stepper.space().vector(), Me = stepper.space().vector();
  {
    const petsc::WriteArray values(e);
    for (std::size_t i = 0; i < values.size(); i += static_cast<std::size_t>(stepper.space().dim()))
      values[i] = 1;
  }
  check(MatMult(stepper.M(), e, Me));
  return petsc::dot(e, Me);
}

} // namespace

MotionSummary::MotionSummary(const Stepper& stepper, const scene::Scene& scene)
    : stepper_(stepper), held_(!scene.clamps.empty()), moving_(stepper.pairs() && stepper.pairs()->moving()),
      last_(scene.contacts.size() + 1) {
  impact_.mass = mass(stepper);
  for (const scene::Contact& contact : scene.contacts)
    impact_.obstacles.push_back({.name = contact.name});
}

void MotionSummary::observe(const Frame& frame, const StepBalance& balance, const ObstacleForces& forces) {
  energy_.kinetic_at_end = balance.kinetic_energy;
  energy_.elastic_at_end = balance.elastic_energy;
  const std::array<double, 3> before = std::exchange(momentum_, balance.momentum);
  if (frame.k == 0) {
    energy_.kinetic_at_start = balance.kinetic_energy;
    energy_.elastic_at_start = balance.elastic_energy;
    return;
  }
  energy_.load_work += balance.load_work;
  energy_.other_work += balance.external_work - balance.load_work;
  energy_.contact_work += balance.contact_work;
  energy_.viscous_dissipation += balance.viscous_dissipation;
  energy_.residual += balance.energy_residual;
  if (impact_.obstacles.empty())
    return;
  const bool pushed = forces.all().normal_force > 0;
  if (pushed && !impact_.all.occurred())
    impact_.before = over(before, impact_.mass);
  if (pushed)
    impact_.after = over(balance.momentum, impact_.mass);
  open_steps_ = pushed || forces.all().active > 0 ? 0 : open_steps_ + 1;
  for (std::size_t i = 0; i < forces.each().size(); ++i)
    take(frame, forces.each()[i], impact_.obstacles[i], last_[i]);
  take(frame, forces.all(), impact_.all, last_.back());
}

void MotionSummary::take(const Frame& frame, const ObstacleForce& now, Touch& touch, Last& last) const {
  const TimeGrid& grid = stepper_.grid();
  const double tau = grid.length(frame.k), earlier = grid.time(frame.k - 1);
  std::array<double, 3> mean{};
  for (std::size_t c = 0; c < 3; ++c)
    mean[c] = (last.force[c] + now.force[c]) / 2;
  touch.peak = std::max(touch.peak, length(mean));
  if (const double normal = (last.normal_force + now.normal_force) / 2; normal > touch.normal_peak) {
    touch.normal_peak = normal;
    touch.peak_time = earlier;
  }
  touch.largest_step = std::max(touch.largest_step, now.normal_force);
  last = {now.force, now.normal_force};
  touch.impulse = now.impulse;
  touch.normal_impulse += tau * now.normal_force;
  if (!(now.normal_force > 0))
    return;
  if (!touch.occurred())
    touch.start = earlier;
  touch.end = grid.time(frame.k);
  touch.contact_time += tau;
}

std::optional<Impact> MotionSummary::impact() const {
  if (impact_.obstacles.empty())
    return std::nullopt;
  Impact impact = impact_;
  impact.ended = open_steps_ >= 2; // single steps without contact occur in rest
  impact.restitution = restitution(impact);
  return impact;
}

std::optional<double> MotionSummary::restitution(const Impact& impact) const {
  if (held_ || moving_ || !impact.ended || std::ranges::count_if(impact.obstacles, &Touch::occurred) != 1)
    return std::nullopt;
  const double towards = product(impact.before, impact.all.impulse),
               away = product(impact.after, impact.all.impulse);
  if (!(towards < 0 && away > 0)) // a body that still comes nearer is about to touch again
    return std::nullopt;
  return -away / towards;
}

} // namespace signorini::forward
