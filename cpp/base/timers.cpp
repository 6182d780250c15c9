// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/timers.h"

namespace signorini {
using Clock = std::chrono::steady_clock;

Timers::Scope::Scope(Timers& timers, Entry& entry)
    : timers_(timers), entry_(entry), around_(timers.running_), start_(Clock::now()) {
  if (around_)
    around_->stop();
  timers_.running_ = this;
}

void Timers::Scope::stop() { entry_.seconds += std::chrono::duration<double>(Clock::now() - start_).count(); }

Timers::Scope::~Scope() {
  stop();
  ++entry_.calls;
  timers_.running_ = around_;
  if (around_)
    around_->start_ = Clock::now();
}

namespace {

std::map<std::string, long>& registry() {
  static std::map<std::string, long> all; // counters of other files are initialised before main, in any order
  return all;
}

} // namespace

long& count(const std::string& name) { return registry()[name]; }

const std::map<std::string, long>& counts() { return registry(); }

} // namespace signorini
