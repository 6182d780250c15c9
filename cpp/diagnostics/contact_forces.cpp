// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/contact_forces.h"
#include "diagnostics/balance.h"
#include "step/functionals.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <utility>

namespace signorini::diagnostics {

namespace {

/// Resets all members except the impulse so far.
void begin(ObstacleForce& one) {
  one = {.min_gap = std::numeric_limits<double>::infinity(),
         .impulse = one.impulse,
         .friction_impulse = one.friction_impulse};
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
  if (stepper_.frictional()) {
    friction_ = forces_;
    std::fill_n(friction_.begin(), pairs.count(), 0.0);
  }
  for (int i = 0; i < pairs.count(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    for (ObstacleForce* one : {&each_[pairs.obstacles()[at]], &all_}) {
      one->normal_force += std::abs(forces_[at]);
      one->active += frame.contact.status[at] != contact::Status::open;
      one->min_gap = std::min(one->min_gap, frame.contact.gap[at]);
    }
  }
  const auto add_force = [&](int obstacle, ObstacleForce& one) {
    for (int c = 0; c < pairs.dim(); ++c) {
      const auto component = static_cast<std::size_t>(c);
      if (!stepper_.space().translates(component))
        continue; // forces around an axis have no radial resultant
      one.force[component] = step::force_on_body(pairs, pairs.rows(), {obstacle, c}, forces_);
      one.impulse[component] += frame.step.tau * one.force[component];
      if (!friction_.empty())
        one.friction_impulse[component] +=
            frame.step.tau * step::force_on_body(pairs, pairs.rows(), {obstacle, c}, friction_);
    }
  };
  add_force(-1, all_);
  for (int obstacle = 0; obstacle < pairs.obstacle_count(); ++obstacle)
    add_force(obstacle, each_[obstacle]);
}

bool LargestForce::observe(double force) {
  constexpr double rounding = 1e-9; // of a step's solution, relative
  if (!(force > (1 + rounding) * largest_))
    return false;
  largest_ = force;
  return true;
}

namespace {

constexpr double unknown = 0.5; // the middle: half a step too early is as likely as too late

/// Returns the time until a gap vanishes if it continues linearly. It went from `far` to `near` in the time
/// `between`. Limited to 0 … `step`, the length of the step; half of `step` if the gap did not fall.
double crossing(double near, double far, double between, double step) {
  return far > near ? std::clamp(between * near / (far - near), 0.0, step) : unknown * step;
}

} // namespace

void ContactTimes::observe(const step::TimeStep& step, const contact::ContactState& contact) {
  step_before_ = std::exchange(step_, step);
  std::swap(before_, last_);
  std::swap(last_, now_);
  now_.clear();
  for (const int i : candidates_)
    now_.push_back(contact.gap[i]);
  if (std::exchange(ending_, false))
    intervals_.back().end = step.begin - since_release();
  std::vector<int> touching;
  for (std::size_t place = 0; place < candidates_.size(); ++place)
    if (contact.status[candidates_[place]] == contact::Status::strong)
      touching.push_back(static_cast<int>(place));
  if (!touching.empty() && touching_.empty())
    intervals_.push_back({step.begin + until_onset(touching), step.end});
  else if (!touching.empty())
    intervals_.back().end = step.end;
  else if (!touching_.empty()) {
    ending_ = true;
    intervals_.back().end = step.begin + step.tau * unknown;
    last_touching_ = touching_;
  }
  touching_ = std::move(touching);
}

double ContactTimes::until_onset(const std::vector<int>& touching) const {
  const double step = step_.tau;
  double first = step;
  for (const int place : touching) {
    const auto i = static_cast<std::size_t>(place);
    const double gap = last_[i];
    first = std::min(first, gap <= 0          ? 0
                            : before_.empty() ? unknown * step
                                              : crossing(gap, before_[i], step_before_.tau, step));
  }
  return first;
}

double ContactTimes::since_release() const {
  double least = step_before_.tau;
  for (const int place : last_touching_) {
    const auto i = static_cast<std::size_t>(place);
    least = std::min(least, crossing(last_[i], now_[i], step_.tau, step_before_.tau));
  }
  return least;
}

std::string obstacle_suffix(int obstacle) { return fmt::format("_{}", obstacle + 1); }

ContactFigures::ContactFigures(const step::Stepper& stepper) : stepper_(stepper), forces_(stepper) {
  const contact::ContactPairs* pairs = stepper.pairs();
  if (!pairs)
    return;
  std::vector<int> all(static_cast<std::size_t>(pairs->count()));
  std::iota(all.begin(), all.end(), 0);
  obstacles_.push_back({"", ContactTimes(all)});
  for (int obstacle = 0; pairs->obstacle_count() > 1 && obstacle < pairs->obstacle_count(); ++obstacle) {
    std::vector<int> own;
    for (const int i : all)
      if (pairs->obstacles()[i] == obstacle)
        own.push_back(i);
    obstacles_.push_back({obstacle_suffix(obstacle), ContactTimes(std::move(own))});
  }
}

void ContactFigures::operator()(const trajectory::Frame& frame) {
  if (obstacles_.empty())
    return;
  forces_.observe(frame);
  for (ObstacleFigures& part : obstacles_)
    part.times.observe(frame.step, frame.contact);
  if (frame.step.k == 0)
    return;
  const double t = frame.step.end;
  obstacles_.front().add(t, forces_.all());
  for (std::size_t part = 1; part < obstacles_.size(); ++part)
    obstacles_[part].add(t, forces_.each()[part - 1]);
}

void ContactFigures::ObstacleFigures::add(double t, const ObstacleForce& now) {
  // Forces of contact-implicit steps alternate, their means over two steps do not (docs/method.md section 2).
  std::array<double, 3> mean{};
  for (std::size_t c = 0; c < mean.size(); ++c)
    mean[c] = (now.force[c] + before[c]) / 2;
  peak = std::max(peak, length(mean));
  before = now.force;
  impulse = now.impulse;
  record.add(t, now.normal_force);
}

std::map<std::string, double> ContactFigures::numbers(double end) const {
  std::map<std::string, double> all;
  for (const ObstacleFigures& part : obstacles_) {
    const std::vector<ContactTimes::Interval> intervals = part.times.intervals();
    double time = 0;
    for (const auto& [start, until] : intervals)
      time += until - start;
    all["impulse" + part.suffix] = length(part.impulse);
    all["impulse_duration" + part.suffix] = part.record.duration();
    all["sustained_peak" + part.suffix] =
        part.record.largest_mean(trajectory::sustained * stepper_.wave_time()).force;
    all["peak_force" + part.suffix] = part.peak;
    all["contact_start" + part.suffix] = intervals.empty() ? end : intervals.front().start;
    all["contact_time" + part.suffix] = time;
  }
  return all;
}

} // namespace signorini::diagnostics
