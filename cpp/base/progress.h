// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace signorini {

/// Writes text to a stream and flushes the stream. Output to a closed pipe is discarded.
void print_text(std::FILE* stream, std::string_view text);

/// Console output of a run. Only rank 0 writes, and only if the run is not quiet.
class Console {
public:
  /// `speaks`: whether this rank writes; `terminal`: whether to draw progress bars (on stderr).
  Console(bool speaks, bool terminal) : speaks_(speaks), terminal_(terminal) {}

  /// Writes one line of text to stdout.
  void line(const std::string& text) const;

  [[nodiscard]] bool speaks() const { return speaks_; }
  [[nodiscard]] bool terminal() const { return terminal_; }

private:
  bool speaks_, terminal_;
};

/// Shows the progress of a loop of known length, with the estimated time left: as a bar on a terminal,
/// otherwise as one line per tenth of the loop.
class Progress {
public:
  /// What `total` is: the number of iterations, or a limit before which the loop may end.
  enum class Total { exact, limit };

  /// `total`: number of iterations; `from`: iterations that an earlier run has done, which do not enter the
  /// time estimate. `console` must outlive this object.
  Progress(const Console& console, std::string label, std::size_t total, std::size_t from = 0,
           Total kind = Total::exact);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows that `done` of `total` iterations are complete, with `note` at the end of the line.
  void update(std::size_t done, const std::string& note = {});

private:
  using Clock = std::chrono::steady_clock;
  const Console& console_;
  std::string label_;
  std::size_t total_, from_, tenth_;
  const char* at_most_; ///< before the time left
  bool drawn_ = false;
  Clock::time_point start_ = Clock::now(), last_{};
};

} // namespace signorini
