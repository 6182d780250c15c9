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

  /// Adds the time from its making to its end to one phase.
  class Scope {
  public:
    explicit Scope(Entry& entry) : entry_(entry), start_(std::chrono::steady_clock::now()) {}
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

  private:
    Entry& entry_;
    std::chrono::steady_clock::time_point start_;
  };

  [[nodiscard]] Scope time(const std::string& phase) { return Scope(entries_[phase]); }
  [[nodiscard]] const std::map<std::string, Entry>& entries() const { return entries_; }

private:
  std::map<std::string, Entry> entries_;
};

} // namespace signorini
