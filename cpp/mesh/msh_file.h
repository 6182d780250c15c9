// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

namespace signorini::mesh {

/// Validated copy of a .msh file in memory, which gmsh reads instead of the file. If a file did not begin as
/// a mesh, gmsh would execute it as a script; gmsh would also read the options in a file x.msh.opt beside it.
/// Since gmsh reads the copy, later changes of the file have no effect.
class MshFile {
public:
  /// Copies and validates the file. Throws UserError if the file cannot be read, does not begin with
  /// $MeshFormat or $Comments, is truncated or does not fit into memory. Not collective.
  explicit MshFile(const std::filesystem::path& file);
  /// Copies and validates the text of a file; `name`: name of the file, for messages.
  MshFile(const std::string& name, const std::string& text);
  ~MshFile();
  MshFile(const MshFile&) = delete;
  MshFile& operator=(const MshFile&) = delete;

  /// Path under which this process can open the copy; unrelated to the path of the file.
  [[nodiscard]] const std::string& path() const { return path_; }

  /// Version of the file's MSH format, such as 2.2 or 4.1.
  [[nodiscard]] double version() const { return version_; }
  /// Number of elements that a file of MSH 2 announces; 0 for other versions.
  [[nodiscard]] std::size_t elements() const { return elements_; }

  using GroupNames = std::map<std::pair<int, int>, std::string>; ///< dimension and number → name
  /// Names of the physical groups, by dimension and number. gmsh itself loses a name that two groups have.
  [[nodiscard]] const GroupNames& group_names() const { return group_names_; }

private:
  int copy_ = -1;
  double version_ = 0;
  std::size_t elements_ = 0;
  GroupNames group_names_;
  std::string path_;
};

} // namespace signorini::mesh
