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

/// Origin of a scene: the scene file, and a function that reads the files of time series.
struct Source {
  const std::filesystem::path& file; ///< scene file, for messages
  ReadFile open;                     ///< reads the files of time series
};

/// Validating access to one table of a scene file. Functions that read a key throw UserError if the key is
/// missing or its value is invalid; finish() rejects keys that were never accessed. Table and source must
/// outlive the reader.
class Reader {
public:
  Reader(const toml::table& table, std::string path, const Source& source)
      : table_(table), path_(std::move(path)), source_(source) {}

  /// Whether the table has the key; the call counts as an access for finish().
  [[nodiscard]] bool has(const std::string& key);
  /// Throws UserError if the key is missing.
  void require(const std::string& key) { (void)node(key); }
  /// Whether the key's value is an array.
  [[nodiscard]] bool is_array(const std::string& key) const { return table_[key].is_array(); }
  /// Whether the key's value is a table other than a time series, which stands for an expression.
  [[nodiscard]] bool is_table(const std::string& key) const {
    const toml::table* table = table_[key].as_table();
    return table && !table->contains("file") && !table->contains("column");
  }
  /// Whether the key's value is a text.
  [[nodiscard]] bool is_text(const std::string& key) const { return table_[key].is_string(); }
  /// Whether the table belongs to an array of tables, as [[material]].
  [[nodiscard]] bool one_of_several() const { return path_.ends_with(']'); }
  double number(const std::string& key, const Limits& limits);
  int integer(const std::string& key, int least, int greatest);
  /// Reads a text that is one line and not empty.
  std::string text(const std::string& key);
  /// Makes a path absolute; relative paths are relative to the scene file. Throws UserError naming `key`.
  [[nodiscard]] std::filesystem::path followed(const std::filesystem::path& given,
                                               const std::string& key) const;
  /// Reads a name; returns its index in `allowed`.
  std::size_t choice(const std::string& key, const std::vector<std::string>& allowed);
  /// Reads a list of names, which may be empty; returns their indices in `allowed`, without repetitions, in
  /// the order of the list.
  std::vector<std::size_t> choices(const std::string& key, const std::vector<std::string>& allowed);
  /// Reads one number per space dimension, 2 or 3.
  std::vector<double> numbers(const std::string& key, const Limits& limits);
  /// Reads one number, or one per space dimension.
  std::vector<double> number_or_numbers(const std::string& key, const Limits& limits);
  /// Reads an array of expressions or time series: one per space dimension, or exactly `count` if `count` is
  /// positive. `end`: end of the motion, s, which time series must cover; absent: t must not occur.
  Components expressions(const std::string& key, std::optional<double> end, std::size_t count = 0);
  /// Reads an expression in x, y, z, and in t too if `time` is true.
  std::string expression(const std::string& key, bool time);
  /// Reads a number, an expression or a time series. `limits`: of a number; `end`: as in expressions().
  Expression number_or_expression(const std::string& key, const Limits& limits, double end);
  bool flag(const std::string& key);
  /// Reads a table of keys of the scene and their values. A key may be a path in quotes, or lead through
  /// tables. Paths of files become absolute.
  std::vector<Change> changes(const std::string& key);
  /// Makes a reader of the table that is the key's value.
  Reader table(const std::string& key);
  /// Makes readers of an array of tables; none if the key is absent. `needed`: whether a present array must
  /// not be empty.
  std::vector<Reader> tables(const std::string& key, bool needed);

  /// Throws UserError for the first key not yet accessed that requests an effect outside the model, or one of
  /// the model under another name (refusal()).
  void refuse() const;
  /// Throws UserError for the first key that was never accessed; the message suggests the accessed key with
  /// the most similar name.
  void finish() const;

  /// Throws UserError that names the file, the line and the full key, followed by `problem`.
  [[noreturn]] void fail(const std::string& key, const std::string& problem) const;

private:
  const toml::node& node(const std::string& key);
  double to_number(const toml::node& node, const std::string& key, const Limits& limits) const;
  [[nodiscard]] std::string full(const std::string& key) const;
  /// Reads a time series. `table`: contains the names of its file and column; `end`: as in expressions().
  Expression series(const toml::table& table, const std::string& key, std::optional<double> end) const;
  /// Throws UserError unless all expressions parse; `time`: whether t may occur.
  void require_readable(const Components& components, const std::string& key, bool time) const;

  const toml::table& table_;
  std::string path_;
  const Source& source_;
  std::set<std::string> known_;
};

} // namespace signorini::scene
