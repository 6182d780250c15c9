// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace signorini {

/// Writes text at once. Output to a closed pipe is discarded.
void print_text(std::FILE* stream, std::string_view text);

/// Console output of a run: only rank 0 writes, and only if the run is not quiet.
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

/// Progress of a loop of known length: on a terminal a bar with the estimated time left, otherwise a line at
/// every tenth.
class Progress {
public:
  /// `from`: iterations done before, which do not count for the estimated time. `console` must outlive this.
  Progress(const Console& console, std::string label, std::size_t total, std::size_t from = 0);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows that `done` of `total` iterations are done, followed by `note`.
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
