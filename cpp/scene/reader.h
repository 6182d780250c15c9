#pragma once
#include "scene/names.h"
#include "scene/scene.h"
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <toml++/toml.hpp>
#include <vector>

namespace signorini::scene {

/// Limits of a number and its unit, for validation and for the message alike.
struct Limits {
  double least = -std::numeric_limits<double>::infinity();
  double greatest = std::numeric_limits<double>::infinity();
  bool open = false; ///< the limits themselves are not allowed
  std::string unit = "no unit";

  [[nodiscard]] bool contain(double value) const;
  [[nodiscard]] std::string text() const;
};

/// One table of the scene file: every access validates, and finish() rejects the keys that nobody asked for.
class Reader {
public:
  Reader(const toml::table& table, std::string path, const std::filesystem::path& file)
      : table_(table), path_(std::move(path)), file_(file) {}

  [[nodiscard]] bool has(const std::string& key);
  double number(const std::string& key, const Limits& limits);
  double number(const std::string& key, const Limits& limits, double fallback);
  int integer(const std::string& key, int least, int greatest, int fallback);
  std::string text(const std::string& key);
  std::string choice(const std::string& key, const std::vector<std::string>& allowed,
                     const std::string& fallback);
  /// Names out of those allowed, each once, in the order given; an empty list is one.
  std::vector<std::string> names(const std::string& key, const std::vector<std::string>& allowed);
  std::vector<double> numbers(const std::string& key, const Limits& limits);
  /// One number, or one per component.
  std::vector<double> number_or_numbers(const std::string& key, const Limits& limits);
  /// One expression per space dimension, or `count` of them.
  Components expressions(const std::string& key, bool time, std::size_t count = 0);
  /// One expression.
  std::string expression(const std::string& key, bool time);
  bool flag(const std::string& key, bool fallback);
  Reader table(const std::string& key);
  std::vector<Reader> tables(const std::string& key);

  /// Throws for the first key that was not asked for, with the nearest one that was.
  void finish() const;

  /// Throws UserError: file, line, key, `problem`.
  [[noreturn]] void fail(const std::string& key, const std::string& problem) const;

private:
  const toml::node& node(const std::string& key);
  double to_number(const toml::node& node, const std::string& key, const Limits& limits) const;
  [[nodiscard]] std::string full(const std::string& key) const;
  /// Throws unless the expressions can be read.
  void require_readable(const Components& components, const std::string& key, bool time) const;

  const toml::table& table_;
  std::string path_;
  const std::filesystem::path& file_;
  std::set<std::string> known_;
};

} // namespace signorini::scene
