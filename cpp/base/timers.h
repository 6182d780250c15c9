// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <chrono>
#include <map>
#include <string>

namespace signorini {

/// Wall-clock seconds and number of calls per named phase of a run.
class Timers {
public:
  struct Entry {
    double seconds = 0;
    long calls = 0;
  };

  /// Adds the time of its lifetime to one phase, without that of phases nested in it.
  class Scope {
  public:
    Scope(Timers& timers, Entry& entry);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

  private:
    void stop();

    Timers& timers_;
    Entry& entry_;
    Scope* around_; ///< the enclosing phase, or null
    std::chrono::steady_clock::time_point start_;
  };

  /// Starts a phase, which ends with the Scope returned; the Timers must outlive it.
  [[nodiscard]] Scope time(const std::string& phase) { return {*this, entries_[phase]}; }
  [[nodiscard]] const std::map<std::string, Entry>& entries() const { return entries_; }

private:
  std::map<std::string, Entry> entries_;
  Scope* running_ = nullptr;
};

/// Returns the counter `name` of this process, zero at first. run.json lists the counters, to show that an
/// effect that is off costs nothing. The reference stays valid: take it once before a loop, so that counting
/// costs an increment. Not collective.
long& count(const std::string& name);

/// All counters of this process, by name. Not collective.
const std::map<std::string, long>& counts();

} // namespace signorini
