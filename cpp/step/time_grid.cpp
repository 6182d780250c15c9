// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/time_grid.h"
#include <algorithm>
#include <bit>
#include <cmath>

namespace signorini::step {

namespace {

constexpr int most_levels = 40;   // of a double's 52 bits
constexpr double rounding = 1e-9; // of divisions of decimal fractions

} // namespace

StepLengths::StepLengths(const scene::Time& time, double floor)
    : end(time.end), longest(time.longest ? static_cast<int>(std::ceil(end / *time.longest - rounding))
                                          : scene::Time::usual_longest),
      levels(0) {
  while (levels < most_levels && length(levels) > floor)
    ++levels;
  if (time.shortest)
    levels =
        std::clamp(static_cast<int>(std::floor(std::log2(length(0) / *time.shortest) + rounding)), 0, levels);
}

std::optional<StepLengths> step_lengths(const scene::Scene& scene, double wave_time) {
  constexpr double usual_tolerance = 1e-2;
  if (!scene.time.automatic())
    return std::nullopt;
  scene::Time time = scene.time;
  const double floor = wave_time / 2 * std::sqrt(time.tolerance / usual_tolerance),
               shortest = StepLengths(time, floor).shortest_step();
  for (const scene::Material& material : scene.materials)
    for (const scene::Branch& branch : material.prony)
      if (const double limit = 2 * branch.time; limit >= shortest)
        time.longest = std::min(limit, time.longest.value_or(time.end / scene::Time::usual_longest));
  return StepLengths(time, floor);
}

int StepLengths::level(double tau) const { return static_cast<int>(std::lround(std::log2(length(0) / tau))); }

TimeGrid::TimeGrid(double tau, int steps) : TimeGrid(Steps{tau, steps, {}, {}}) {}

TimeGrid::TimeGrid(const StepLengths& step_lengths)
    : TimeGrid(Steps{step_lengths.shortest_step(), 0, step_lengths, {0}}) {}

TimeGrid::TimeGrid(const scene::Time& time)
    : TimeGrid(time.automatic() ? TimeGrid(StepLengths(time, 0)) : TimeGrid(time.step, time.steps)) {}

std::optional<TimeGrid> TimeGrid::of_levels(const StepLengths& step_lengths,
                                            const std::vector<double>& levels) {
  TimeGridBuilder builder(step_lengths);
  for (const double level : levels) {
    const int whole = static_cast<int>(level);
    if (builder.complete() || !(level >= builder.least_level() && level <= step_lengths.levels) ||
        whole != level)
      return std::nullopt;
    builder.add(whole);
  }
  return builder.complete() ? std::optional(builder.grid()) : std::nullopt;
}

TimeGrid TimeGrid::first(int steps) const {
  Steps fewer = *steps_;
  if (equal())
    fewer.count = steps;
  else
    fewer.ticks.resize(static_cast<std::size_t>(steps) + 1);
  return TimeGrid(std::move(fewer));
}

int TimeGrid::steps() const { return equal() ? steps_->count : static_cast<int>(steps_->ticks.size()) - 1; }

bool TimeGrid::complete() const { return equal() || steps_->ticks.back() == steps_->step_lengths->ticks(); }

double TimeGrid::time(int k) const {
  if (equal())
    return k * steps_->tick;
  return k > 0 && k == steps() && complete() ? steps_->step_lengths->end
                                             : static_cast<double>(steps_->ticks[k]) * steps_->tick;
}

double TimeGrid::length(int k) const {
  if (equal())
    return steps_->tick;
  if (steps() == 0)
    return steps_->step_lengths->shortest_step();
  const auto i = static_cast<std::size_t>(std::max(k, 1));
  return static_cast<double>(steps_->ticks[i] - steps_->ticks[i - 1]) * steps_->tick;
}

double TimeGrid::middle(int k) const {
  return equal() ? (k - 0.5) * steps_->tick : time(k - 1) + length(k) / 2;
}

double TimeGrid::end() const { return equal() ? time(steps()) : steps_->step_lengths->end; }

TimeGrid::Place TimeGrid::place(double t) const {
  if (equal()) {
    const double step = std::clamp(t / steps_->tick, 0.0, static_cast<double>(steps_->count));
    const int k = std::clamp(static_cast<int>(std::ceil(step)), 1, steps_->count);
    return {k, step - (k - 1)};
  }
  const double tick = t / steps_->tick;
  const std::vector<std::int64_t>& ticks = steps_->ticks;
  const auto after =
      std::lower_bound(ticks.begin() + 1, ticks.end() - 1, tick,
                       [](std::int64_t at, double asked) { return static_cast<double>(at) < asked; });
  const auto from = static_cast<double>(after[-1]), to = static_cast<double>(*after);
  return {static_cast<int>(after - ticks.begin()), std::clamp((tick - from) / (to - from), 0.0, 1.0)};
}

std::vector<double> TimeGrid::levels() const {
  std::vector<double> all;
  for (int k = 1; !equal() && k <= steps(); ++k)
    all.push_back(steps_->step_lengths->level(length(k)));
  return all;
}

int TimeGridBuilder::least_level() const {
  const std::int64_t here = ticks_.back();
  return here == 0 ? 0
                   : std::max(0, step_lengths_.levels - std::countr_zero(static_cast<std::uint64_t>(here)));
}

TimeStep TimeGridBuilder::add(int level) {
  const std::int64_t before = ticks_.back(), length = StepLengths::parts(step_lengths_.levels - level);
  ticks_.push_back(before + length);
  const double tick = step_lengths_.shortest_step();
  return {steps(), static_cast<double>(before) * tick,
          complete() ? step_lengths_.end : static_cast<double>(ticks_.back()) * tick,
          static_cast<double>(length) * tick};
}

TimeGrid TimeGridBuilder::grid() const {
  return TimeGrid(TimeGrid::Steps{step_lengths_.shortest_step(), 0, step_lengths_, ticks_});
}

} // namespace signorini::step
