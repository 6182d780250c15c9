// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <vector>

namespace signorini::scene {

/// One row of a table of cases.
struct CaseRow {
  std::string name;                ///< unique
  int line = 0;                    ///< line of the table, for messages
  std::vector<std::string> values; ///< texts of the keys' values; empty where the scene's own value holds
};

/// Cases of a scene: a column for each key that they change.
struct CaseTable {
  std::vector<std::string> keys; ///< paths of keys, as --set takes them
  std::vector<CaseRow> rows;

  /// Returns the changes of a case as texts `key.path=value`, as --set takes them.
  [[nodiscard]] std::vector<std::string> overrides(std::size_t i) const;
};

/// Reads a table of cases from a CSV text. Its first line names the columns: paths of keys and, if wanted,
/// `name`; cases without a name are numbered from 1. Cells are numbers or other values in TOML, in quotes if
/// they contain the separator. Throws UserError naming line or column.
CaseTable read_cases(const std::string& text);

} // namespace signorini::scene
