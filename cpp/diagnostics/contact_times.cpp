// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/contact_times.h"
#include <algorithm>
#include <utility>

namespace signorini::diagnostics {
namespace {

constexpr double unknown = 0.5; // half a step too early as likely as too late

/// The time until a gap vanishes that was `far` and then, after the time `between`, `near`; within a step of
/// length `step`.
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
    now_.push_back(contact.gap[static_cast<std::size_t>(i)]);
  if (std::exchange(ending_, false))
    intervals_.back().end = step.begin - since_release();
  std::vector<int> touching;
  for (std::size_t place = 0; place < candidates_.size(); ++place)
    if (contact.status[static_cast<std::size_t>(candidates_[place])] == contact::Status::strong)
      touching.push_back(static_cast<int>(place));
  if (!touching.empty() && touching_.empty())
    intervals_.push_back({step.begin + until_onset(touching), step.end});
  else if (!touching.empty())
    intervals_.back().end = step.end;
  else if (!touching_.empty()) {
    ending_ = true;
    intervals_.back().end = step.begin + step.tau * unknown;
    held_ = touching_;
  }
  touching_ = std::move(touching);
}

std::vector<ContactTimes::Interval> ContactTimes::intervals() const { return intervals_; }

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
  for (const int place : held_) {
    const auto i = static_cast<std::size_t>(place);
    least = std::min(least, crossing(last_[i], now_[i], step_.tau, step_before_.tau));
  }
  return least;
}

} // namespace signorini::diagnostics
