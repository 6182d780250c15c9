// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/choices.h"
#include "scene/scene.h"
#include "scene/units.h"
#include <set>
#include <string>
#include <string_view>
#include <toml++/toml.hpp>
#include <vector>

namespace signorini::scene {

/// Where a scene comes from.
struct Source {
  const std::filesystem::path& file; ///< for messages
  ReadFile open;                     ///< reads the files of time series
};

/// Validating access to one table of the scene file: every access throws UserError for a wrong value or a
/// missing key without fallback, and finish() rejects keys that were never accessed. Table and source must
/// outlive it.
class Reader {
public:
  Reader(const toml::table& table, std::string path, const Source& source)
      : table_(table), path_(std::move(path)), source_(source) {}

  /// Whether the table has the key; counts as an access.
  [[nodiscard]] bool has(const std::string& key);
  /// Throws UserError for a missing key.
  void require(const std::string& key) { (void)node(key); }
  /// Whether the key's value is an array.
  [[nodiscard]] bool is_array(const std::string& key) const { return table_[key].is_array(); }
  /// Whether it is a table.
  [[nodiscard]] bool is_table(const std::string& key) const { return table_[key].is_table(); }
  /// Whether it is a text.
  [[nodiscard]] bool is_text(const std::string& key) const { return table_[key].is_string(); }
  /// Whether the table is one of an array.
  [[nodiscard]] bool one_of_several() const { return path_.ends_with(']'); }
  double number(const std::string& key, const Limits& limits);
  int integer(const std::string& key, int least, int greatest);
  /// A text on one line, not empty.
  std::string text(const std::string& key);
  /// An absolute path, of one that is relative to the scene file or absolute. Throws UserError for `key`.
  [[nodiscard]] std::filesystem::path followed(const std::filesystem::path& given,
                                               const std::string& key) const;
  /// The number of one of the names allowed.
  std::size_t choice(const std::string& key, const std::vector<std::string>& allowed);
  /// The numbers of a list of allowed names, without repetitions, in the order given; it may be empty.
  std::vector<std::size_t> choices(const std::string& key, const std::vector<std::string>& allowed);
  /// One number per space dimension, 2 or 3.
  std::vector<double> numbers(const std::string& key, const Limits& limits);
  /// One number, or one per space dimension.
  std::vector<double> number_or_numbers(const std::string& key, const Limits& limits);
  /// One expression per space dimension, or `count` of them if positive; `end`: the last time for which they
  /// are evaluated, s; none: t is not allowed.
  Components expressions(const std::string& key, std::optional<double> end, std::size_t count = 0);
  /// One expression of place.
  std::string expression(const std::string& key, bool time);
  /// A number, or an expression.
  Expression number_or_expression(const std::string& key, const Limits& limits, double end);
  bool flag(const std::string& key);
  /// Reader of a subtable.
  Reader table(const std::string& key);
  /// Readers of an array of tables; none if the key is absent, and of an empty array unless one is needed.
  std::vector<Reader> tables(const std::string& key, bool needed);

  /// Throws UserError for the first key that was never accessed and asks for an effect that the model lacks.
  void refuse() const;
  /// Throws UserError for the first key that was never accessed, suggesting the nearest one that was.
  void finish() const;

  /// Throws UserError with file, line, key and `problem`.
  [[noreturn]] void fail(const std::string& key, const std::string& problem) const;

private:
  const toml::node& node(const std::string& key);
  double to_number(const toml::node& node, const std::string& key, const Limits& limits) const;
  [[nodiscard]] std::string full(const std::string& key) const;
  /// A time series that a table names; `end` as in expressions().
  Expression series(const toml::table& table, const std::string& key, std::optional<double> end) const;
  /// Throws UserError unless the expressions parse.
  void require_readable(const Components& components, const std::string& key, bool time) const;

  const toml::table& table_;
  std::string path_;
  const Source& source_;
  std::set<std::string> known_;
};

} // namespace signorini::scene
