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

  /// Adds the time from its making to its end to one phase, less that of phases within.
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
    Scope* around_; ///< the phase that this one is within
    std::chrono::steady_clock::time_point start_;
  };

  [[nodiscard]] Scope time(const std::string& phase) { return {*this, entries_[phase]}; }
  [[nodiscard]] const std::map<std::string, Entry>& entries() const { return entries_; }

private:
  std::map<std::string, Entry> entries_;
  Scope* running_ = nullptr;
};

} // namespace signorini
