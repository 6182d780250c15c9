// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/impact_summary.h"
#include "diagnostics/body_figures.h"
#include <algorithm>
#include <cmath>
#include <functional>

namespace signorini::diagnostics {
namespace {

constexpr double early = 0.25; ///< part of a contact in which it begins
constexpr int least_open = 2;  // steps; single ones without contact occur in rest

std::array<double, 3> over(std::array<double, 3> x, double divisor) {
  for (double& component : x)
    component /= divisor;
  return x;
}

/// Returns for each component whether the body can move freely along it: whether it translates along it, and
/// no node is clamped in it. Collective.
std::array<bool, 3> free_components(const step::Stepper& stepper) {
  const int dim = stepper.space().dim();
  std::array<int, 3> clamped{};
  for (const int dof : stepper.clamped().dofs())
    clamped[dof % dim] = 1;
  MPI_Allreduce(MPI_IN_PLACE, clamped.data(), 3, MPI_INT, MPI_MAX, stepper.space().comm());
  std::array<bool, 3> free{};
  for (std::size_t c = 0; c < static_cast<std::size_t>(dim); ++c)
    free[c] = clamped[c] == 0 && stepper.space().translates(c);
  return free;
}

} // namespace

std::optional<ImpactSummary::Two>
ImpactSummary::two_bodies(const step::Stepper& stepper, const scene::Contact& contact, const Bodies& bodies) {
  Two two{.body = bodies.of_group(contact.on, "contact.on"),
          .other = bodies.of_group(*contact.against, "contact.against"),
          .fixed = false,
          .side = 1};
  if (two.body < 0 || two.other < 0 || two.body == two.other)
    return std::nullopt;
  const auto clamped = [&](int body, std::size_t c) {
    return bodies.all()[static_cast<std::size_t>(body)].clamped[c];
  };
  // Clamps of both, as at a symmetry plane, and of the axis hold no body against the other one.
  const auto held = [&](int body, int other) {
    for (std::size_t c = 0; c < static_cast<std::size_t>(stepper.space().dim()); ++c)
      if (stepper.space().translates(c) && clamped(body, c) && !clamped(other, c))
        return true;
    return false;
  };
  if (held(two.body, two.other) && !held(two.other, two.body)) {
    std::swap(two.body, two.other);
    two.side = -1;
  }
  two.fixed = held(two.other, two.body);
  return two;
}

ImpactSummary::ImpactSummary(const step::Stepper& stepper, const scene::Scene& scene, const Bodies* bodies)
    : stepper_(stepper), bodies_(bodies), free_(free_components(stepper)),
      moving_(stepper.pairs() && stepper.pairs()->moving()),
      last_(scene.contacts.size() + 1, Last{.open = least_open}), records_(last_.size()) {
  const BodyFigures figures = body_figures(stepper, scene);
  impact_.mass = figures.mass;
  crossing_ = figures.crossing;
  const auto flies = [](const scene::RigidBody& body) {
    return body.inertia.empty() && body.stiffness.empty() && body.damping.empty();
  };
  if (scene.contacts.size() == 1 && scene.contacts.front().rigid && flies(*scene.contacts.front().rigid))
    flies_ = stepper.pairs()->rigid(0);
  if (bodies && scene.contacts.size() == 1)
    two_ = two_bodies(stepper, scene.contacts.front(), *bodies);
  if (two_) {
    const Bodies::Body& body = bodies->all()[static_cast<std::size_t>(two_->body)];
    impact_.mass = body.mass;
    impact_.body = body.name;
    impact_.other = bodies->all()[static_cast<std::size_t>(two_->other)].name;
    for (std::size_t c = 0; c < 3; ++c)
      free_[c] = c < static_cast<std::size_t>(stepper.space().dim()) && stepper.space().translates(c) &&
                 !body.clamped[c];
  }
  for (const scene::Contact& contact : scene.contacts)
    impact_.obstacles.push_back({.name = contact.name});
}

void ImpactSummary::observe(const trajectory::Frame& frame, const StepBalance& balance,
                            const ObstacleForces& forces) {
  energy_.kinetic_at_end = balance.kinetic_energy;
  energy_.elastic_at_end = balance.elastic_energy;
  energy_.foundation_at_end = balance.foundation_energy;
  energy_.relaxation_at_end = balance.relaxation_energy;
  energy_.rigid_at_end = balance.rigid_energy;
  const std::array<double, 3> before = std::exchange(momentum_, body_momentum(balance));
  now_ = frame.step.end;
  for (std::size_t i = 0; frame.step.k == 0 && bodies_ && i < bodies_->all().size(); ++i) {
    const Bodies::Body& body = bodies_->all()[i];
    impact_.bodies.push_back(
        {.name = body.name, .mass = body.mass, .at_start = bodies_->velocity(static_cast<int>(i))});
  }
  const Velocity obstacle_before = std::exchange(obstacle_velocity_, velocity_of_other(frame));
  const auto note_gap = [t = frame.step.end](const ObstacleForce& now, Touch& touch) {
    if (now.min_gap < touch.least_gap) {
      touch.least_gap = now.min_gap;
      touch.least_gap_time = t;
    }
  };
  for (std::size_t i = 0; i < impact_.obstacles.size(); ++i)
    note_gap(forces.each()[i], impact_.obstacles[i]);
  note_gap(forces.all(), impact_.all);
  if (frame.step.k == 0) {
    energy_.kinetic_at_start = balance.kinetic_energy;
    energy_.elastic_at_start = balance.elastic_energy;
    energy_.foundation_at_start = balance.foundation_energy;
    energy_.rigid_at_start = balance.rigid_energy;
    return;
  }
  energy_.load_work += balance.load_work;
  energy_.other_work += balance.external_work - balance.load_work;
  energy_.contact_work += balance.contact_work;
  energy_.friction_work += balance.friction_work;
  energy_.belt_work += balance.belt_work;
  energy_.viscous_dissipation += balance.viscous_dissipation;
  energy_.foundation_dissipation += balance.foundation_dissipation;
  energy_.drag_dissipation += balance.drag_dissipation;
  energy_.relaxation_dissipation += balance.relaxation_dissipation;
  energy_.rigid_dissipation += balance.rigid_dissipation;
  energy_.residual += balance.energy_residual;
  if (impact_.obstacles.empty())
    return;
  const bool pushed = forces.all().normal_force > 0;
  if (pushed)
    rebound(frame, forces.all(), before, momentum_, obstacle_before);
  open_steps_ = pushed || forces.all().active > 0 ? 0 : open_steps_ + 1;
  parted_ = !pushed && (parted_ || open_steps_ >= least_open);
  for (std::size_t i = 0; i < forces.each().size(); ++i)
    take(frame, forces.each()[i], impact_.obstacles[i], last_[i]);
  take(frame, forces.all(), impact_.all, last_.back());
  for (std::size_t i = 0; i < records_.size(); ++i)
    records_[i].add(frame.step.end, last_[i].normal_force);
}

std::array<double, 3> ImpactSummary::body_momentum(const StepBalance& balance) const {
  return two_ ? bodies_->motions()[static_cast<std::size_t>(two_->body)].momentum : balance.momentum;
}

ImpactSummary::Velocity ImpactSummary::velocity_of_other(const trajectory::Frame& frame) const {
  if (flies_)
    return flies_->place(frame.after.v()).translation;
  if (two_ && !two_->fixed)
    return bodies_->velocity(two_->other);
  return std::nullopt;
}

void ImpactSummary::rebound(const trajectory::Frame& frame, const ObstacleForce& now,
                            const std::array<double, 3>& before, const std::array<double, 3>& after,
                            const Velocity& obstacle_before) {
  const auto begun = [&] {
    return Rebound{
        .start = frame.step.begin, .before = over(before, impact_.mass), .obstacle_before = obstacle_before};
  };
  if (touches_.empty())
    impact_.whole = begun();
  if (parted_) { // before a step that closes a gap without a force, too
    impulse_ = impact_.whole.impulse;
    friction_impulse_ = impact_.whole.friction_impulse;
    touches_.push_back(begun());
  }
  Rebound& touch = touches_.back();
  for (Rebound* one : {&impact_.whole, &touch}) {
    one->end = frame.step.end;
    one->after = over(after, impact_.mass);
    one->obstacle_after = obstacle_velocity_;
    one->impulse = now.impulse;
    one->friction_impulse = now.friction_impulse;
    for (std::array<double, 3>* impulse : {&one->impulse, &one->friction_impulse})
      for (double& component : *impulse)
        component *= two_ ? two_->side : 1; // on the body
  }
  for (std::size_t c = 0; c < 3; ++c) {
    touch.impulse[c] -= impulse_[c];
    touch.friction_impulse[c] -= friction_impulse_[c];
  }
  const double mean = (last_.back().normal_force + now.normal_force) / 2;
  touch.peak = std::max(touch.peak, mean);
  impact_.whole.peak = std::max(impact_.whole.peak, mean);
}

void ImpactSummary::take(const trajectory::Frame& frame, const ObstacleForce& now, Touch& touch,
                         Last& last) const {
  const double tau = frame.step.tau, earlier = frame.step.begin;
  std::array<double, 3> mean{};
  for (std::size_t c = 0; c < 3; ++c)
    mean[c] = (last.force[c] + now.force[c]) / 2;
  if (now.normal_force > 0 && last.open >= least_open)
    last.begun = earlier;
  last.open = now.normal_force > 0 ? 0 : last.open + 1;
  touch.peak = std::max(touch.peak, length(mean));
  if (const double normal = (last.normal_force + now.normal_force) / 2; normal > touch.normal_peak) {
    touch.normal_peak = normal;
    touch.peak_time = earlier;
    touch.peak_at_onset = earlier <= last.begun + crossing_;
  }
  touch.largest_step = std::max(touch.largest_step, now.normal_force);
  last.force = now.force;
  last.normal_force = now.normal_force;
  touch.impulse = now.impulse;
  touch.normal_impulse += tau * now.normal_force;
  touch.friction_impulse = now.friction_impulse;
  if (!(now.normal_force > 0))
    return;
  if (!touch.occurred())
    touch.start = earlier;
  touch.end = frame.step.end;
  touch.contact_time += tau;
}

std::optional<Impact> ImpactSummary::impact() const {
  if (impact_.obstacles.empty())
    return std::nullopt;
  Impact impact = impact_;
  const auto sum_up = [&](const trajectory::ImpulseRecord& record, Touch& touch) {
    touch.impulse_duration = record.duration();
    const trajectory::ImpulseRecord::Mean most =
        record.largest_mean(trajectory::sustained * stepper_.wave_time());
    touch.sustained_over = most.over;
    touch.sustained_peak = most.force;
  };
  for (std::size_t i = 0; i < impact.obstacles.size(); ++i)
    sum_up(records_[i], impact.obstacles[i]);
  sum_up(records_.back(), impact.all);
  // A front's peak is early in a contact. Of a large body, or of the larger of two, waves return only after a
  // smooth pulse has had its peak in the middle.
  const auto late = [](const Touch& touch) {
    return touch.peak_time - touch.start > early * (touch.end - touch.start);
  };
  if (touches_.size() == 1)
    for (Touch* touch : {&impact.all, impact.obstacles.size() == 1 ? &impact.obstacles.front() : nullptr})
      if (touch && late(*touch))
        touch->peak_at_onset = false;
  impact.ended = open_steps_ >= least_open;
  impact.no_restitution = no_restitution_reason();
  for (std::size_t i = 0; i < impact.bodies.size(); ++i)
    impact.bodies[i].at_end = bodies_->velocity(static_cast<int>(i));
  impact.whole.touches = static_cast<int>(touches_.size());
  impact.bounces = bounces();
  if (!impact.no_restitution.empty())
    return impact;
  for (Rebound& bounce : impact.bounces)
    if (&bounce != &impact.bounces.back() || impact.ended)
      bounce.restitution = restitution(bounce);
  if (!impact.ended)
    impact.no_restitution = "contact has not ended";
  else if (impact.whole.restitution = restitution(impact.whole); !impact.whole.restitution)
    impact.no_restitution =
        along(impact.whole.before, impact.whole.normal_impulse(), impact.whole.obstacle_before) < 0
            ? "the body still approaches the obstacle at the end"
            : "the body did not approach the obstacle before contact";
  return impact;
}

bool ImpactSummary::bounced() const {
  return impact_.all.occurred() && open_steps_ >= least_open && now_ - impact_.whole.end > 2 * crossing_ &&
         (!no_restitution_reason().empty() || restitution(impact_.whole));
}

bool Impact::begins(double t, double crossing) const {
  return std::ranges::any_of(bounces, [&](const Rebound& one) {
    return one.start <= t && t <= one.start + std::min(crossing, early * (one.end - one.start));
  });
}

std::vector<Rebound> ImpactSummary::bounces() const {
  const bool restitution_possible = no_restitution_reason().empty();
  std::vector<Rebound> all;
  for (const Rebound& touch : touches_) {
    all.push_back(touch);
    while (all.size() > 1 && one_bounce(all[all.size() - 2], all.back(), restitution_possible)) {
      const Rebound last = all.back();
      all.pop_back();
      Rebound& bounce = all.back();
      bounce.end = last.end;
      bounce.after = last.after;
      bounce.obstacle_after = last.obstacle_after;
      bounce.touches += last.touches;
      bounce.peak = std::max(bounce.peak, last.peak);
      for (std::size_t c = 0; c < 3; ++c) {
        bounce.impulse[c] += last.impulse[c];
        bounce.friction_impulse[c] += last.friction_impulse[c];
      }
    }
  }
  return all;
}

bool ImpactSummary::one_bounce(const Rebound& first, const Rebound& second, bool restitution_possible) const {
  constexpr double brief = 0.5; // of the shorter one: a body at rest after a bounce is in contact for long
  const double pause = second.start - first.end,
               shorter = std::min(first.end - first.start, second.end - second.start);
  return pause <= std::max(brief * shorter, 2 * crossing_) ||
         (restitution_possible && along(first.after, first.impulse, first.obstacle_after) <= 0);
}

double ImpactSummary::along(const std::array<double, 3>& velocity, const std::array<double, 3>& impulse,
                            const Velocity& obstacle) const {
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c)
    if (free_[c])
      sum += (velocity[c] - (obstacle ? (*obstacle)[c] : 0)) * impulse[c];
  return sum;
}

std::optional<double> ImpactSummary::restitution(const Rebound& rebound) const {
  const std::array<double, 3> n = rebound.normal_impulse();
  const double towards = along(rebound.before, n, rebound.obstacle_before),
               away = along(rebound.after, n, rebound.obstacle_after);
  if (!(towards < 0 && away > 0)) // a body that still comes nearer is about to touch again
    return std::nullopt;
  return -away / towards;
}

std::string ImpactSummary::no_restitution_reason() const {
  if (!impact_.all.occurred())
    return "the body touched no obstacle";
  if (stepper_.space().mesh().axisymmetric() && length(impact_.whole.impulse) == 0)
    return "radial forces have no resultant";
  constexpr double rounding = 1e-12;
  if (const std::array<double, 3> J = impact_.whole.normal_impulse();
      along(J, J) <= rounding * length(J) * length(J))
    return "clamps hold the body in the direction of the contact force";
  if (stepper_.operators().foundation_A || stepper_.operators().foundation_B)
    return "a foundation acts on the body";
  if (stepper_.operators().drag)
    return "mass damping acts on the body";
  if (bodies_ && !two_)
    return "several bodies touch";
  if (moving_ || (!stepper_.space().layout().virtual_nodes().empty() && !flies_))
    return "an obstacle moves, and not freely";
  return std::ranges::count_if(impact_.obstacles, &Touch::occurred) > 1 ? "several obstacles were touched"
                                                                        : "";
}

} // namespace signorini::diagnostics
