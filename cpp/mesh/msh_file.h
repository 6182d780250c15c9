// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <string>

namespace signorini::mesh {

/// A validated copy of a .msh in memory, to be read by gmsh in place of the file: gmsh would run a file that
/// does not begin as a mesh as a script, and run the options of a file beside it (x.msh.opt). What is
/// validated is what gmsh reads, even if the file changes.
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

private:
  int copy_ = -1;
  std::string path_;
};

} // namespace signorini::mesh
