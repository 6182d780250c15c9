#pragma once
#include "io/folder_lock.h"
#include <filesystem>
#include <fstream>
#include <mpi.h>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace signorini::io {

/// The folder that a run leaves its files in. Files are written into a hidden folder inside it and moved out
/// together at the end, so that each appears whole or not at all and a failed run leaves everything as it
/// was.
class OutputFolder {
public:
  /// Makes the folder, takes it for this run alone and tidies up after runs that were killed. Collective. Throws UserError on
  /// every rank if the folder cannot be written, another run has it, or a file is in the way that no run wrote; but for
  /// that called `given`, which this run reads and judges itself.
  OutputFolder(MPI_Comm comm, const std::filesystem::path& folder, std::string_view given = {});
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to write the file that will be called `name`.
  [[nodiscard]] std::filesystem::path staged(const std::string& name) const { return staging_ / name; }

  /// Writes a text file, on rank 0. Collective. Throws UserError.
  void write(const std::string& name, const std::string& text) const;

  /// Removes everything written. Not collective.
  void discard() const;

  /// Moves everything written into place and removes what an earlier run left under the fixed names and this
  /// one did not write; all of it, or nothing if it throws. Collective. Throws UserError.
  void publish();

  /// What run.json, which is written last, stands for: the files of this run, and those of earlier ones that stay. On rank 0.
  [[nodiscard]] FolderLock::Names files() const;

  [[nodiscard]] const std::filesystem::path& path() const { return folder_; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

private:
  MPI_Comm comm_;
  std::filesystem::path folder_, staging_;
  std::optional<FolderLock> lock_; ///< on rank 0
};

/// A text file of the folder, written piece by piece on rank 0.
class TextFile {
public:
  /// `folder` must outlive this object.
  TextFile(const OutputFolder& folder, const std::string& name);

  /// Not collective; a failure shows at close().
  void append(std::string_view text);

  /// Collective. Throws UserError if not all of it could be written.
  void close();

private:
  const OutputFolder& folder_;
  std::string name_;
  std::ofstream out_; ///< open on rank 0
  int error_ = 0;     ///< errno of the first failure
};

} // namespace signorini::io
