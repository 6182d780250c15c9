#pragma once
#include <chrono>
#include <cstddef>
#include <string>

namespace signorini {

/// Where a run says what it does: rank 0 of a run that is not quiet. Everything else is silent.
class Console {
public:
  Console(bool speaks, bool terminal) : speaks_(speaks), terminal_(terminal) {}

  /// One line of text.
  void line(const std::string& text) const;

  [[nodiscard]] bool speaks() const { return speaks_; }
  [[nodiscard]] bool terminal() const { return terminal_; }

private:
  bool speaks_, terminal_;
};

/// Progress of a loop of known length: a bar with the time left on a terminal, a line at every tenth otherwise.
class Progress {
public:
  /// `from`: what is done already, and took none of this progress's time.
  Progress(const Console& console, std::string label, std::size_t total, std::size_t from = 0);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` of `total` are done; `note` is shown behind the numbers.
  void update(std::size_t done, const std::string& note = {});

private:
  using Clock = std::chrono::steady_clock;
  const Console& console_;
  std::string label_;
  std::size_t total_, from_, tenth_;
  bool drawn_ = false;
  Clock::time_point start_ = Clock::now(), last_{};
};

} // namespace signorini
