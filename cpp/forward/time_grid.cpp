// SPDX-License-Identifier: GPL-3.0-or-later
#include "forward/time_grid.h"
#include <algorithm>
#include <bit>
#include <cmath>

namespace signorini::forward {

namespace {

constexpr int most_levels = 40;   // of a double's 52 bits
constexpr double rounding = 1e-9; // of divisions of decimal fractions

} // namespace

Ladder::Ladder(const scene::Time& time, double floor)
    : end(time.end), longest(time.longest ? static_cast<int>(std::ceil(end / *time.longest - rounding))
                                          : scene::Time::usual_longest),
      levels(0) {
  while (levels < most_levels && length(levels) > floor)
    ++levels;
  if (time.shortest)
    levels =
        std::clamp(static_cast<int>(std::floor(std::log2(length(0) / *time.shortest) + rounding)), 0, levels);
}

TimeGrid::TimeGrid(const scene::Time& time, double floor)
    : TimeGrid(time.automatic() ? TimeGrid(Ladder(time, floor)) : TimeGrid(time.step, time.steps)) {}

TimeGrid::TimeGrid(double tau, int steps) : steps_(std::make_shared<Steps>(Steps{tau, steps, {}, {}})) {}

TimeGrid::TimeGrid(const Ladder& ladder)
    : steps_(std::make_shared<Steps>(Steps{ladder.length(ladder.levels), 0, ladder, {0}})) {}

int TimeGrid::steps() const { return equal() ? steps_->count : static_cast<int>(steps_->ticks.size()) - 1; }

bool TimeGrid::complete() const {
  return equal() || steps_->ticks.back() == steps_->ladder->longest * Ladder::parts(steps_->ladder->levels);
}

double TimeGrid::time(int k) const {
  if (equal())
    return k * steps_->tick;
  return k > 0 && k == steps() && complete()
             ? steps_->ladder->end
             : static_cast<double>(steps_->ticks[static_cast<std::size_t>(k)]) * steps_->tick;
}

double TimeGrid::length(int k) const {
  if (equal())
    return steps_->tick;
  if (k == 0)
    return first_length();
  const auto i = static_cast<std::size_t>(k);
  return static_cast<double>(steps_->ticks[i] - steps_->ticks[i - 1]) * steps_->tick;
}

double TimeGrid::middle(int k) const {
  return equal() ? (k - 0.5) * steps_->tick : time(k - 1) + length(k) / 2;
}

double TimeGrid::end() const { return equal() ? time(steps()) : steps_->ladder->end; }

double TimeGrid::longest() const { return equal() ? steps_->tick : steps_->ladder->length(0); }

double TimeGrid::first_length() const {
  return steps() > 0 ? length(1) : steps_->ladder->length(steps_->ladder->levels);
}

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

int TimeGrid::level(int k) const {
  const auto i = static_cast<std::size_t>(k);
  return steps_->ladder->levels -
         std::countr_zero(static_cast<std::uint64_t>(steps_->ticks[i] - steps_->ticks[i - 1]));
}

int TimeGrid::least_level() const {
  const std::int64_t here = steps_->ticks.back();
  const int levels = steps_->ladder->levels;
  return here == 0 ? 0 : std::max(0, levels - std::countr_zero(static_cast<std::uint64_t>(here)));
}

void TimeGrid::add(int level) {
  steps_->ticks.push_back(steps_->ticks.back() + Ladder::parts(steps_->ladder->levels - level));
}

void TimeGrid::remove() { steps_->ticks.pop_back(); }

std::vector<double> TimeGrid::levels() const {
  std::vector<double> all;
  for (int k = 1; !equal() && k <= steps(); ++k)
    all.push_back(level(k));
  return all;
}

bool TimeGrid::take(const std::vector<double>& levels) {
  TimeGrid other(*steps_->ladder);
  for (const double level : levels) {
    const int whole = static_cast<int>(level);
    if (other.complete() || !(level >= other.least_level() && level <= steps_->ladder->levels) ||
        whole != level)
      return false;
    other.add(whole);
  }
  if (!other.complete())
    return false;
  steps_->ticks = other.steps_->ticks;
  return true;
}

void TimeGrid::clear() { steps_->ticks.resize(1); }

} // namespace signorini::forward
