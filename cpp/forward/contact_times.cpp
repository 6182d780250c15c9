#include "forward/contact_times.h"
#include <algorithm>
#include <utility>

namespace signorini::forward {
namespace {

constexpr double unknown = 0.5; // half a step too early as likely as too late

/// The fraction of the way from 0 on after which a gap vanishes that was `far` and then `near`.
double crossing(double near, double far) {
  return far > near ? std::clamp(near / (far - near), 0.0, 1.0) : unknown;
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
    intervals_.back().end = grid_.time(k - 2) + grid_.length(k - 1) * release();
  std::vector<int> touching;
  for (std::size_t place = 0; place < candidates_.size(); ++place)
    if (contact.status[static_cast<std::size_t>(candidates_[place])] == contact::Status::strong)
      touching.push_back(static_cast<int>(place));
  if (!touching.empty() && touching_.empty())
    intervals_.push_back({grid_.time(k - 1) + grid_.length(k) * onset(touching), grid_.time(k)});
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

double ContactTimes::onset(const std::vector<int>& touching) const {
  double first = 1;
  for (const int place : touching) {
    const auto i = static_cast<std::size_t>(place);
    const double gap = last_[i];
    first = std::min(first, gap <= 0 ? 0 : before_.empty() ? unknown : crossing(gap, before_[i]));
  }
  return first;
}

double ContactTimes::release() const {
  double last = 0;
  for (const int place : held_) {
    const auto i = static_cast<std::size_t>(place);
    last = std::max(last, 1 - crossing(last_[i], now_[i]));
  }
  return last;
}

} // namespace signorini::forward
