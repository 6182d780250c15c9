// SPDX-License-Identifier: GPL-3.0-or-later
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

/// Flushes a file, or a folder's entries, to the disk. Throws filesystem_error.
void synchronise(const std::filesystem::path& path);

/// Folder for the files of a run. Files are written into a hidden folder inside it and moved out together at
/// the end. Thus each appears whole or not at all, and a failed run leaves everything as it was.
class OutputFolder {
public:
  /// Creates and locks the folder, and completes or removes the remains of killed runs. Collective. Throws
  /// OutputFailure on every rank if the folder cannot be written, UserError if another run has locked it.
  /// Throws UserError if it contains a file of this run's names that no run wrote, except `given`, which this
  /// run reads and checks itself.
  OutputFolder(MPI_Comm comm, const std::filesystem::path& folder, std::string_view given = {});
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Whether runs write files of that name into their folders.
  [[nodiscard]] static bool writes(std::string_view name);

  /// The path at which to write the file `name` until publish().
  [[nodiscard]] std::filesystem::path staged(const std::string& name) const { return staging_ / name; }

  /// Writes a text file, on rank 0. Collective. Throws OutputFailure.
  void write(const std::string& name, const std::string& text) const;

  /// Throws UserError if the folder has files that only a search leaves and this run would remove; `given`:
  /// its path as given by the user. Collective.
  void require_no_search(const std::filesystem::path& given) const;

  /// Moves everything written into place. Removes an earlier run's files under the fixed names that this one
  /// did not write, and the page and figures that postprocess/ made of it. All of it happens, or nothing if
  /// it throws. Returns the removed page and figures, by their paths within the folder, on rank 0.
  /// Collective. Throws OutputFailure.
  std::vector<std::string> publish();

  /// Files to be listed in run.json, which is written last: those of this run, and a checkpoint that stays.
  /// On rank 0.
  [[nodiscard]] FolderLock::Names files() const;

  /// Size of what has been written so far, bytes. Zero on ranks other than 0.
  [[nodiscard]] double bytes() const;

  [[nodiscard]] const std::filesystem::path& path() const { return folder_; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

private:
  MPI_Comm comm_;
  std::filesystem::path folder_, staging_;
  std::optional<FolderLock> lock_; ///< on rank 0
};

/// Text file of the folder, written in parts on rank 0.
class TextFile {
public:
  /// `folder` must outlive this object.
  TextFile(const OutputFolder& folder, const std::string& name);

  /// Appends on rank 0. Not collective; a failure is reported by close().
  void append(std::string_view text);

  /// Bytes appended so far; on rank 0. Not collective.
  [[nodiscard]] std::streamoff size() const { return size_; }

  /// Inserts a text after the first `at` bytes, on rank 0. Not collective; a failure is reported by close().
  void insert(std::streamoff at, std::string_view text);

  /// Closes the file. Collective. Throws OutputFailure if not all of it could be written.
  void close();

private:
  const OutputFolder& folder_;
  std::string name_;
  std::fstream out_; ///< open on rank 0
  std::streamoff size_ = 0;
  int error_ = 0; ///< errno of the first failure
};

} // namespace signorini::io
