#pragma once
#include <filesystem>
#include <string>

namespace signorini::mesh {

/// A copy of a .msh in memory, for gmsh, which runs as a script what does not begin as a mesh, and the options that
/// it finds in a file beside one (x.msh.opt). What is looked at is what gmsh gets, whatever becomes of the file.
class MshFile {
public:
  /// Throws UserError for a file that cannot be read, does not begin as MSH or was cut short.
  explicit MshFile(const std::filesystem::path& file);
  ~MshFile();
  MshFile(const MshFile&) = delete;
  MshFile& operator=(const MshFile&) = delete;

  /// Under which this process can open it; it says nothing of the file's own name.
  [[nodiscard]] const std::string& path() const { return path_; }

private:
  int copy_ = -1;
  std::string path_;
};

} // namespace signorini::mesh
