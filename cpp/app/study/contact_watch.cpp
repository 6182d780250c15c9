// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/study/contact_watch.h"
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace signorini::study {
namespace {

double length(const std::array<double, 3>& x) { return std::hypot(x[0], x[1], x[2]); }

} // namespace

std::string suffix(int obstacle) { return fmt::format("_{}", obstacle + 1); }

std::vector<Quantity> contact_quantities(const scene::Scene& scene, int dim) {
  const std::string each = dim == 2 ? "/m" : "";
  std::vector<Quantity> all;
  const auto add = [&](const std::string& end, const std::string& of) {
    all.push_back({"impulse" + end, "impulse of contact" + of, "N s" + each});
    all.push_back({"impulse_duration" + end, "time from 1 to 99 % of the impulse" + of, "s"});
    all.push_back({"sustained_peak" + end, "sustained peak force" + of, "N" + each, false, false, false});
    all.push_back({"peak_force" + end, "peak force of two steps" + of, "N" + each, false, false, false});
    all.push_back({"contact_start" + end, "start of contact" + of, "s"});
    all.push_back({"contact_time" + end, "time in contact" + of, "s", false, false, false});
  };
  if (!scene.contacts.empty())
    add("", "");
  if (scene.contacts.size() > 1)
    for (int obstacle = 0; obstacle < std::ssize(scene.contacts); ++obstacle)
      add(suffix(obstacle), fmt::format(", obstacle {}", obstacle + 1));
  return all;
}

ContactWatch::ContactWatch(const forward::Stepper& stepper) : stepper_(stepper), forces_(stepper) {
  const contact::ContactPairs* pairs = stepper.pairs();
  if (!pairs)
    return;
  std::vector<int> all(static_cast<std::size_t>(pairs->count()));
  std::iota(all.begin(), all.end(), 0);
  parts_.push_back({"", forward::ContactTimes(all)});
  for (int obstacle = 0; pairs->obstacle_count() > 1 && obstacle < pairs->obstacle_count(); ++obstacle) {
    std::vector<int> own;
    for (const int i : all)
      if (pairs->obstacles()[static_cast<std::size_t>(i)] == obstacle)
        own.push_back(i);
    parts_.push_back({suffix(obstacle), forward::ContactTimes(std::move(own))});
  }
}

void ContactWatch::operator()(const forward::Frame& frame) {
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

void ContactWatch::Part::add(double t, const forward::ObstacleForce& now) {
  // Forces of contact-implicit steps alternate, their means over two steps do not (docs/method.md section 2).
  std::array<double, 3> mean{};
  for (std::size_t c = 0; c < mean.size(); ++c)
    mean[c] = (now.force[c] + before[c]) / 2;
  peak = std::max(peak, length(mean));
  before = now.force;
  impulse = now.impulse;
  record.add(t, now.normal_force);
}

std::map<std::string, double> ContactWatch::numbers(double end) const {
  std::map<std::string, double> all;
  for (const Part& part : parts_) {
    const std::vector<forward::ContactTimes::Interval> intervals = part.times.intervals();
    double time = 0;
    for (const auto& [start, until] : intervals)
      time += until - start;
    all["impulse" + part.suffix] = length(part.impulse);
    all["impulse_duration" + part.suffix] = part.record.duration();
    all["sustained_peak" + part.suffix] =
        part.record.largest_mean(forward::sustained * stepper_.wave_time()).force;
    all["peak_force" + part.suffix] = part.peak;
    all["contact_start" + part.suffix] = intervals.empty() ? end : intervals.front().start;
    all["contact_time" + part.suffix] = time;
  }
  return all;
}

} // namespace signorini::study
