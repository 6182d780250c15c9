#pragma once
#include <filesystem>
#include <mpi.h>
#include <string>
#include <vector>

namespace signorini::io {

/// The folder that a run leaves its files in. Files are written into a hidden folder inside it and moved out together at
/// the end, so that each appears whole or not at all and a failed run leaves everything as it was.
class OutputFolder {
public:
  /// Makes the folder. Collective. Throws UserError on every rank if that cannot be done.
  OutputFolder(MPI_Comm comm, const std::filesystem::path& folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to write the file that will be called `name`.
  [[nodiscard]] std::filesystem::path staged(const std::string& name) const { return staging_ / name; }

  /// Writes a text file, on rank 0. Collective. Throws UserError.
  void write(const std::string& name, const std::string& text) const;

  /// Removes everything written. Not collective.
  void discard() const;

  /// Moves everything written into place and removes what an earlier run left under the fixed names and this one did not
  /// write. Collective. Throws UserError.
  void publish();

  [[nodiscard]] const std::filesystem::path& path() const { return folder_; }

private:
  MPI_Comm comm_;
  std::filesystem::path folder_, staging_;
  std::vector<std::filesystem::path> made_; ///< folders that did not exist before, innermost first; on rank 0
};

} // namespace signorini::io
