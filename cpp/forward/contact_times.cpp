// SPDX-License-Identifier: GPL-3.0-or-later
#include "forward/contact_times.h"
#include <algorithm>
#include <utility>

namespace signorini::forward {
namespace {

constexpr double unknown = 0.5; // half a step too early as likely as too late

/// The time until a gap vanishes that was `far` and then, after the time `between`, `near`; within a step of
/// length `step`.
double crossing(double near, double far, double between, double step) {
  return far > near ? std::clamp(between * near / (far - near), 0.0, step) : unknown * step;
}

} // namespace

ContactTimes::ContactTimes(TimeGrid grid, std::vector<int> candidates)
    : grid_(grid), candidates_(std::move(candidates)) {}

void ContactTimes::observe(int k, const contact::ContactState& contact) {
  k_ = k;
  std::swap(before_, last_);
  std::swap(last_, now_);
  now_.clear();
  for (const int i : candidates_)
    now_.push_back(contact.gap[static_cast<std::size_t>(i)]);
  if (std::exchange(ending_, false))
    intervals_.back().end = grid_.time(k - 1) - since_release();
  std::vector<int> touching;
  for (std::size_t place = 0; place < candidates_.size(); ++place)
    if (contact.status[static_cast<std::size_t>(candidates_[place])] == contact::Status::strong)
      touching.push_back(static_cast<int>(place));
  if (!touching.empty() && touching_.empty())
    intervals_.push_back({grid_.time(k - 1) + until_onset(touching), grid_.time(k)});
  else if (!touching.empty())
    intervals_.back().end = grid_.time(k);
  else if (!touching_.empty()) {
    ending_ = true;
    intervals_.back().end = grid_.time(k - 1) + grid_.length(k) * unknown;
    held_ = touching_;
  }
  touching_ = std::move(touching);
}

std::vector<ContactTimes::Interval> ContactTimes::intervals() const { return intervals_; }

double ContactTimes::until_onset(const std::vector<int>& touching) const {
  const double step = grid_.length(k_);
  double first = step;
  for (const int place : touching) {
    const auto i = static_cast<std::size_t>(place);
    const double gap = last_[i];
    first = std::min(first, gap <= 0          ? 0
                            : before_.empty() ? unknown * step
                                              : crossing(gap, before_[i], grid_.length(k_ - 1), step));
  }
  return first;
}

double ContactTimes::since_release() const {
  double least = grid_.length(k_ - 1);
  for (const int place : held_) {
    const auto i = static_cast<std::size_t>(place);
    least = std::min(least, crossing(last_[i], now_[i], grid_.length(k_), grid_.length(k_ - 1)));
  }
  return least;
}

} // namespace signorini::forward
