// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <chrono>
#include <map>
#include <string>

namespace signorini {

/// Wall-clock time, s, and number of calls of each named phase of a run.
class Timers {
public:
  struct Entry {
    double seconds = 0;
    long calls = 0;
  };

  /// Scope guard that adds the time of its lifetime to one phase. The time of phases nested in it is not
  /// counted.
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

  /// Starts a phase, which ends when the returned Scope is destroyed; the Timers must outlive the Scope.
  [[nodiscard]] Scope time(const std::string& phase) { return {*this, entries_[phase]}; }
  [[nodiscard]] const std::map<std::string, Entry>& entries() const { return entries_; }

private:
  std::map<std::string, Entry> entries_;
  Scope* running_ = nullptr;
};

/// Returns this process's counter `name`, which starts at zero. run.json lists all counters, to show that an
/// effect that the scene does not contain costs nothing. The reference stays valid: get it once before a
/// loop, so that counting costs one increment. Not collective.
long& count(const std::string& name);

/// Returns all counters of this process, by name. Not collective.
const std::map<std::string, long>& counts();

} // namespace signorini
