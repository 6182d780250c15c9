// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

/// What the fuzzers share: damaged copies of texts that are right, the same ones for the same seed.
namespace signorini::fuzz {

inline std::string read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw std::runtime_error(file.string() + " cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  if (!out.write(text.data(), static_cast<std::streamsize>(text.size())).flush())
    throw std::runtime_error(file.string() + " cannot be written");
}

/// The files of a folder with an ending, in the same order everywhere.
inline std::vector<std::filesystem::path> files(const std::filesystem::path& folder,
                                                const std::string& ending) {
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ending)
      found.push_back(entry.path());
  std::ranges::sort(found);
  return found;
}

using Pieces = std::vector<std::string>;

inline std::string joined(const Pieces& pieces) {
  std::string text;
  for (const std::string& piece : pieces)
    text += piece;
  return text;
}

inline Pieces lines(const std::string& text) {
  Pieces pieces;
  for (std::size_t start = 0, end = 0; start < text.size(); start = end) {
    end = text.find('\n', start);
    end = end == std::string::npos ? text.size() : end + 1;
    pieces.push_back(text.substr(start, end - start));
  }
  return pieces;
}

/// Words and numbers, blanks, and every other character by itself.
inline Pieces tokens(const std::string& text) {
  const auto kind = [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '.' || c == '-' || c == '+' ? 1
           : c == ' ' || c == '\t'                                         ? 2
                                                                           : 0;
  };
  Pieces pieces;
  for (std::size_t start = 0, end = 0; start < text.size(); start = end) {
    const int first = kind(static_cast<unsigned char>(text[start]));
    end = start + 1;
    while (first != 0 && end < text.size() && kind(static_cast<unsigned char>(text[end])) == first)
      ++end;
    pieces.push_back(text.substr(start, end - start));
  }
  return pieces;
}

class Mutator {
public:
  /// `words`: what may take a token's place, beside the tokens of the other texts and numbers at the ends of
  /// their ranges.
  Mutator(std::uint64_t seed, Pieces texts, Pieces words)
      : random_(seed), texts_(std::move(texts)), words_(std::move(words)) {
    for (const std::string& text : texts_)
      for (const std::string& token : tokens(text))
        words_.push_back(token);
    std::ranges::sort(words_);
    const auto [last, end] = std::ranges::unique(words_);
    words_.erase(last, end);
  }

  /// One of the texts with a few things wrong, or none.
  std::string next() {
    std::string text = one_of(texts_);
    do
      damage(text);
    while (below(2) == 0);
    return text;
  }

  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_() % n); }

private:
  template <class Choices>
  const typename Choices::value_type& one_of(const Choices& choices) {
    return choices[below(choices.size())];
  }

  void damage(std::string& text) {
    switch (below(10)) {
    case 0:
      bytes(text);
      return;
    case 1:
      rearrange(text, lines(text), lines(one_of(texts_)));
      return;
    case 2:
    case 3:
      rearrange(text, tokens(text), words_);
      return;
    case 4:
      text.insert(below(text.size() + 1), long_text());
      return;
    case 5:
      text.insert(below(text.size() + 1), one_of(odd_characters));
      return;
    default:
      replace(text);
    }
  }

  void bytes(std::string& text) {
    if (text.empty())
      return;
    const std::size_t at = below(text.size()), count = 1 + below(std::min<std::size_t>(text.size() - at, 40));
    switch (below(5)) {
    case 0:
      text[at] = static_cast<char>(below(256));
      return;
    case 1:
      text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
      return;
    case 2:
      text.erase(at, count);
      return;
    case 3:
      text.insert(below(text.size()), text.substr(at, count));
      return;
    default:
      text.resize(at);
    }
  }

  /// Deletes, doubles, swaps or takes over pieces.
  void rearrange(std::string& text, Pieces pieces, const Pieces& others) {
    if (pieces.empty())
      return;
    const auto at = pieces.begin() + static_cast<std::ptrdiff_t>(below(pieces.size()));
    switch (below(4)) {
    case 0:
      pieces.erase(at,
                   at + static_cast<std::ptrdiff_t>(1 + below(std::min<std::size_t>(4, pieces.end() - at))));
      break;
    case 1:
      pieces.insert(at, *at + "");
      break;
    case 2:
      std::swap(*at, pieces[below(pieces.size())]);
      break;
    default:
      pieces.insert(at, one_of(others));
    }
    text = joined(pieces);
  }

  /// Another token in place of one, a number where there was one more often than not.
  void replace(std::string& text) {
    Pieces pieces = tokens(text);
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < pieces.size(); ++i)
      if (pieces[i].find_first_of("0123456789") != std::string::npos)
        numbers.push_back(i);
    if (pieces.empty())
      return;
    const bool number = !numbers.empty() && below(4) != 0;
    const std::size_t at = number ? one_of(numbers) : below(pieces.size());
    pieces[at] = below(3) == 0 ? one_of(words_) : number ? one_of(extremes) : one_of(values);
    text = joined(pieces);
  }

  std::string long_text() {
    const std::size_t count = std::size_t{1} << below(14);
    std::string text;
    const std::string piece = below(2) == 0 ? std::string(one_of(brackets)) : one_of(words_);
    while (text.size() < count)
      text += piece + (piece.empty() ? " " : "");
    return text;
  }

  static constexpr std::array extremes{"0",
                                       "-0",
                                       "1",
                                       "2",
                                       "3",
                                       "-1",
                                       "0.5",
                                       "1e308",
                                       "-1e308",
                                       "1e309",
                                       "1e-308",
                                       "4.9e-324",
                                       "1e-400",
                                       "inf",
                                       "-inf",
                                       "nan",
                                       "+nan",
                                       "1e15",
                                       "1e16",
                                       "1e-15",
                                       "1e17",
                                       "127",
                                       "128",
                                       "255",
                                       "256",
                                       "65536",
                                       "0x7fffffff",
                                       "0o17",
                                       "0b11",
                                       "2147483647",
                                       "2147483648",
                                       "-2147483648",
                                       "4294967295",
                                       "4294967296",
                                       "9223372036854775807",
                                       "-9223372036854775808",
                                       "9223372036854775808",
                                       "18446744073709551615",
                                       "1_000",
                                       "01",
                                       ".5",
                                       "5.",
                                       "1e",
                                       "1e999999999",
                                       "0.30000000000000004",
                                       "100000000",
                                       "1000000"};
  static constexpr std::array values{"true",
                                     "false",
                                     "[]",
                                     "{}",
                                     "\"\"",
                                     "''",
                                     "[[]]",
                                     "[1, 2]",
                                     "\"t\"",
                                     "\"x\"",
                                     "1979-05-27",
                                     "07:32:00",
                                     "1979-05-27T07:32:00Z",
                                     "\"\"\"",
                                     "'''",
                                     "\n",
                                     "\t",
                                     "\r\n",
                                     "#",
                                     "=",
                                     ".",
                                     ",",
                                     "\"",
                                     "\\",
                                     "[",
                                     "]",
                                     "{",
                                     "}"};
  static constexpr std::array brackets{"[",  "]", "{", "}", "(",   ")", "[[",   "\"", "'", "[{a=",
                                       "(-", "-", "0", "9", "../", "x", "sin(", "1?", "a."};
  static constexpr std::array odd_characters{
      "\xc3\xbc", "\xe2\x82\xac", "\xf0\x9f\x98\x80", "\xe2\x80\xa8", "\xef\xbb\xbf", "\xc2\x85", "\xff",
      "\xc0\x80", "\xed\xa0\x80", "\xe2\x82",         "\x7f",         "\x01",         "\\u0000",  "\\u001b",
      "\\n",      "\\x",          "\\ud800",          "\\U0010ffff"};
  std::mt19937_64 random_;
  Pieces texts_, words_;
};

/// Processor time of this process, s: it does not depend on what else the machine does.
inline double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

class Stopwatch {
public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// What the command line of a fuzzer asks for: SEED COUNT SOURCE_DIR FOLDER.
struct Task {
  std::uint64_t seed;
  long count;
  std::filesystem::path source, folder; ///< the folder is made
};

/// Nothing, and a line on stderr, where it is not that.
inline std::optional<Task> task(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: %s SEED COUNT SOURCE_DIR FOLDER\n",
                 std::filesystem::path(argv[0]).filename().c_str());
    return std::nullopt;
  }
  std::filesystem::create_directories(argv[4]);
  return Task{std::stoull(argv[1]), std::stol(argv[2]), argv[3], argv[4]};
}

/// Tries the inputs that were found before, of one ending; how many there are.
template <class Run>
int replay(Run& run, const Task& task, const std::string& ending) {
  for (const auto& file : files(task.source / "tests/fuzz/found", ending))
    run.take(read(file));
  return run.inputs;
}

} // namespace signorini::fuzz
