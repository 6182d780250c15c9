// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

namespace signorini::mesh {

/// Validated copy of a .msh in memory, which gmsh reads in place of the file. gmsh itself would run a file
/// that does not begin as a mesh as a script, and the options of a file beside it (x.msh.opt). The validated
/// text is what gmsh reads, even if the file changes.
class MshFile {
public:
  /// Throws UserError for a file that cannot be read, does not begin as MSH, is truncated or does not fit
  /// into memory. Not collective.
  explicit MshFile(const std::filesystem::path& file);
  ~MshFile();
  MshFile(const MshFile&) = delete;
  MshFile& operator=(const MshFile&) = delete;

  /// Path under which this process can open the copy; unrelated to the file's own.
  [[nodiscard]] const std::string& path() const { return path_; }

  /// Version of its format, such as 2.2 or 4.1.
  [[nodiscard]] double version() const { return version_; }
  /// Number of elements that the file announces, 0 if its format does not.
  [[nodiscard]] std::size_t elements() const { return elements_; }

  using GroupNames = std::map<std::pair<int, int>, std::string>; ///< dimension and number → name
  /// Names of groups: gmsh drops a name that a second group has too.
  [[nodiscard]] const GroupNames& group_names() const { return group_names_; }

private:
  int copy_ = -1;
  double version_ = 0;
  std::size_t elements_ = 0;
  GroupNames group_names_;
  std::string path_;
};

} // namespace signorini::mesh
