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

/// Origin of a scene: its file and access to the files of time series.
struct Source {
  const std::filesystem::path& file; ///< scene file, for messages
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
  /// Whether the key's value is a table.
  [[nodiscard]] bool is_table(const std::string& key) const { return table_[key].is_table(); }
  /// Whether the key's value is a text.
  [[nodiscard]] bool is_text(const std::string& key) const { return table_[key].is_string(); }
  /// Whether the table is one of an array.
  [[nodiscard]] bool one_of_several() const { return path_.ends_with(']'); }
  double number(const std::string& key, const Limits& limits);
  int integer(const std::string& key, int least, int greatest);
  /// Reads a text on one line, not empty.
  std::string text(const std::string& key);
  /// Returns the absolute path of one that is relative to the scene file or absolute. Throws UserError for
  /// `key`.
  [[nodiscard]] std::filesystem::path followed(const std::filesystem::path& given,
                                               const std::string& key) const;
  /// Reads one of the allowed names; returns its number.
  std::size_t choice(const std::string& key, const std::vector<std::string>& allowed);
  /// Reads a list of allowed names, which may be empty; returns their numbers, without repetitions, in the
  /// order given.
  std::vector<std::size_t> choices(const std::string& key, const std::vector<std::string>& allowed);
  /// Reads one number per space dimension, 2 or 3.
  std::vector<double> numbers(const std::string& key, const Limits& limits);
  /// Reads one number, or one per space dimension.
  std::vector<double> number_or_numbers(const std::string& key, const Limits& limits);
  /// Reads one expression per space dimension, or `count` of them if positive. `end`: the last time for which
  /// they are evaluated, s; none: t is not allowed.
  Components expressions(const std::string& key, std::optional<double> end, std::size_t count = 0);
  /// Reads one expression of place, with `time` of t too.
  std::string expression(const std::string& key, bool time);
  /// Reads a number, or an expression of t.
  Expression number_or_expression(const std::string& key, const Limits& limits, double end);
  bool flag(const std::string& key);
  /// Reader of a subtable.
  Reader table(const std::string& key);
  /// Readers of an array of tables; none if the key is absent. The array may be empty unless one is needed.
  std::vector<Reader> tables(const std::string& key, bool needed);

  /// Throws UserError for the first key not accessed that is the name of an effect outside the model.
  void refuse() const;
  /// Throws UserError for the first key that was never accessed, suggesting the nearest one that was.
  void finish() const;

  /// Throws UserError with file, line, key and `problem`.
  [[noreturn]] void fail(const std::string& key, const std::string& problem) const;

private:
  const toml::node& node(const std::string& key);
  double to_number(const toml::node& node, const std::string& key, const Limits& limits) const;
  [[nodiscard]] std::string full(const std::string& key) const;
  /// Reads the time series that a table names; `end` as in expressions().
  Expression series(const toml::table& table, const std::string& key, std::optional<double> end) const;
  /// Throws UserError unless the expressions parse.
  void require_readable(const Components& components, const std::string& key, bool time) const;

  const toml::table& table_;
  std::string path_;
  const Source& source_;
  std::set<std::string> known_;
};

} // namespace signorini::scene
