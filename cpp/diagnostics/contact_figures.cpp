// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/contact_figures.h"
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace signorini::diagnostics {
namespace {

double length(const std::array<double, 3>& x) { return std::hypot(x[0], x[1], x[2]); }

} // namespace

std::string obstacle_suffix(int obstacle) { return fmt::format("_{}", obstacle + 1); }

ContactFigures::ContactFigures(const step::Stepper& stepper) : stepper_(stepper), forces_(stepper) {
  const contact::ContactPairs* pairs = stepper.pairs();
  if (!pairs)
    return;
  std::vector<int> all(static_cast<std::size_t>(pairs->count()));
  std::iota(all.begin(), all.end(), 0);
  parts_.push_back({"", ContactTimes(all)});
  for (int obstacle = 0; pairs->obstacle_count() > 1 && obstacle < pairs->obstacle_count(); ++obstacle) {
    std::vector<int> own;
    for (const int i : all)
      if (pairs->obstacles()[static_cast<std::size_t>(i)] == obstacle)
        own.push_back(i);
    parts_.push_back({obstacle_suffix(obstacle), ContactTimes(std::move(own))});
  }
}

void ContactFigures::operator()(const trajectory::Frame& frame) {
  if (parts_.empty())
    return;
  forces_.observe(frame);
  for (Part& part : parts_)
    part.times.observe(frame.step, frame.contact);
  if (frame.step.k == 0)
    return;
  const double t = frame.step.end;
  parts_.front().add(t, forces_.all());
  for (std::size_t part = 1; part < parts_.size(); ++part)
    parts_[part].add(t, forces_.each()[part - 1]);
}

void ContactFigures::Part::add(double t, const ObstacleForce& now) {
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
  for (const Part& part : parts_) {
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
