// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/progress.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini {
namespace {

std::string duration(double seconds) {
  const auto s = static_cast<long>(std::ceil(seconds));
  return s < 60 ? fmt::format("{} s", s) : fmt::format("{} min {:02} s", s / 60, s % 60);
}

} // namespace

void print_text(std::FILE* stream, std::string_view text) {
  (void)std::fwrite(text.data(), 1, text.size(), stream);
  (void)std::fflush(stream);
}

void Console::line(const std::string& text) const {
  if (speaks_)
    print_text(stdout, text + "\n");
}

Progress::Progress(const Console& console, std::string label, std::size_t total, std::size_t from, Total kind)
    : console_(console), label_(std::move(label)), total_(total), from_(from),
      tenth_(total > 0 ? 10 * from / total : 0), at_most_(kind == Total::limit ? "at most " : "") {}

Progress::~Progress() {
  if (drawn_)
    print_text(stderr, "\r\033[K");
}

void Progress::update(std::size_t done, const std::string& note) {
  done = std::min(done, total_); // a search may be given more than was foreseen
  if (!console_.speaks() || total_ == 0)
    return;
  const auto now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double left =
      done > from_ ? seconds * static_cast<double>(total_ - done) / static_cast<double>(done - from_) : 0;
  if (console_.terminal()) {
    if (done < total_ && now - last_ < std::chrono::milliseconds(100))
      return;
    last_ = now;
    constexpr std::size_t width = 28;
    const std::size_t filled = width * done / total_;
    print_text(stderr,
               fmt::format("\r\033[K{} [{}{}] {}/{}  {}{} left  {}", label_, std::string(filled, '#'),
                           std::string(width - filled, '.'), done, total_, at_most_, duration(left), note));
    drawn_ = true;
  } else if (const std::size_t tenth = 10 * done / total_; tenth > tenth_) {
    tenth_ = tenth;
    // Loops of a few seconds need no progress lines.
    if (seconds > 3 || left > 3)
      console_.line(
          fmt::format("{} {}/{}  {}{} left  {}", label_, done, total_, at_most_, duration(left), note));
  }
}

} // namespace signorini
