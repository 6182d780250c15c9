// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/impulse_record.h"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace signorini::trajectory {

void ImpulseRecord::add(double t, double force) {
  const double tau = t - end_, sum = sums_.back() + force * tau;
  const std::size_t n = times_.size();
  end_ = t;
  if (n > 2 && sum == sums_[n - 1] && sums_[n - 1] == sums_[n - 2]) {
    times_.back() = t, lengths_.back() = tau;
    return;
  }
  times_.push_back(t);
  sums_.push_back(sum);
  lengths_.push_back(tau);
}

double ImpulseRecord::until(double t) const {
  const auto after = std::ranges::lower_bound(times_, t);
  if (after == times_.end())
    return sums_.back();
  const auto i = static_cast<std::size_t>(after - times_.begin());
  if (i == 0)
    return 0;
  const double part = (t - times_[i - 1]) / (times_[i] - times_[i - 1]);
  return sums_[i - 1] + part * (sums_[i] - sums_[i - 1]);
}

std::pair<double, double> ImpulseRecord::between(double from, double to) const {
  const auto time_of = [&](double sum) {
    const auto above = std::ranges::lower_bound(sums_, sum);
    if (above == sums_.end() || above == sums_.begin())
      return above == sums_.begin() ? times_.front() : times_.back();
    const auto i = static_cast<std::size_t>(above - sums_.begin());
    return times_[i - 1] + (sum - sums_[i - 1]) / (sums_[i] - sums_[i - 1]) * (times_[i] - times_[i - 1]);
  };
  if (!(total() > 0))
    return {0, 0};
  return {time_of(from * total()), time_of(to * total())};
}

double ImpulseRecord::duration() const {
  constexpr double part = 0.01;
  const auto [begin, end] = between(part, 1 - part);
  return end - begin;
}

ImpulseRecord::Mean ImpulseRecord::largest_mean(double window) const {
  Mean most{.over = window};
  for (std::size_t i = 1; i < times_.size(); ++i) {
    const double before = lengths_[i > 1 ? i - 1 : i]; // of a motion that begins in contact, too
    const double length = std::max(window, lengths_[i] + before);
    const double force = (sums_[i] - until(times_[i] - length)) / length;
    if (force > most.force)
      most = {force, length, times_[i]};
  }
  return most;
}

ImpulseRecord::Peak ImpulseRecord::peak(double window) const {
  Peak peak{.mean = largest_mean(window)};
  const auto [force, over, at] = peak.mean;
  const double half = largest_mean(over / 2).force, fourfold = largest_mean(4 * over).force;
  peak.twice = largest_mean(2 * over).force;
  peak.excess = force / peak.twice - 1;
  const auto [begin, end] = between(0.01, 0.99);
  const double sine = std::pow(2 * std::numbers::pi * over / (end - begin), 2) / 24;
  peak.expected = std::min(sine, (peak.twice - fourfold) / (4 * peak.twice));
  peak.smooth = half - force <= (force - peak.twice) / 2;
  return peak;
}

} // namespace signorini::trajectory
