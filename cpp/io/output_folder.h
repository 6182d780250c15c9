// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "io/folder_lock.h"
#include <filesystem>
#include <fstream>
#include <mpi.h>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace signorini::io {

/// Flushes a file, or the entries of a folder, to the disk. Throws std::filesystem::filesystem_error.
void synchronise(const std::filesystem::path& path);

/// Writes a file as a whole in place of an earlier one, or leaves that one. Returns the error. Not
/// collective.
[[nodiscard]] std::error_code try_replace_file(const std::filesystem::path& file, std::string_view content);
/// Replaces a file of a results' folder as a whole: an interruption leaves the old file or the new one.
/// Throws OutputFailure.
void replace_file(const std::filesystem::path& file, std::string_view content);

/// Whether postprocess/ made a file, such as report.html. Not collective.
[[nodiscard]] bool is_drawn(const std::filesystem::path& file);

/// Output folder of a run. Files are written into a hidden folder inside the output folder; publish() moves
/// them out together at the end. Thus no incomplete file appears, and a failed run leaves the earlier files
/// unchanged.
class OutputFolder {
public:
  /// Creates and locks the folder, and completes or removes the remains of killed runs. Throws OutputFailure
  /// on every rank if the folder cannot be written. Throws UserError if another run has locked the folder, or
  /// if a file in the folder has the name of an output file but was not written by a run. `given`: name of a
  /// file exempt from this check, since the run reads and checks it itself. Collective.
  OutputFolder(MPI_Comm comm, const std::filesystem::path& folder, std::string_view given = {});
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Whether runs write files with this name into their output folders.
  [[nodiscard]] static bool writes(std::string_view name);

  /// Path at which to write the file `name`, from where publish() moves it.
  [[nodiscard]] std::filesystem::path staged(const std::string& name) const { return staging_ / name; }

  /// Writes `text` into the output file `name`, on rank 0. Throws OutputFailure. Collective.
  void write(const std::string& name, const std::string& text) const;

  /// Throws UserError if the folder has files that only a search writes, since publishing this run would
  /// remove them. `given`: path of the folder as given by the user, for the message. Collective.
  void require_no_search(const std::filesystem::path& given) const;

  /// Moves all written files into the output folder. Removes files of an earlier run that this run does not
  /// replace, and the pages and figures that postprocess/ made of the earlier run. If it throws, the folder
  /// is unchanged. Returns the paths of the removed pages and figures, relative to the folder, on rank 0.
  /// Throws OutputFailure. Collective.
  std::vector<std::string> publish();

  /// Names of the files to be listed in run.json: the files that this run has written, run.json itself and,
  /// if the folder has one, the checkpoint. Call this on rank 0, after all files but run.json are written.
  [[nodiscard]] FolderLock::Names files() const;

  /// Total size of the files written so far, bytes. Zero on ranks other than 0.
  [[nodiscard]] double bytes() const;

  [[nodiscard]] const std::filesystem::path& path() const { return folder_; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

private:
  MPI_Comm comm_;
  std::filesystem::path folder_, staging_; ///< output folder, and hidden folder inside it
  std::optional<FolderLock> lock_;         ///< on rank 0
};

/// Text file of an output folder, written in parts on rank 0.
class TextFile {
public:
  /// Opens the file `name` of the folder, on rank 0; a failure is reported by close(). `folder` must outlive
  /// this object.
  TextFile(const OutputFolder& folder, const std::string& name);

  /// Appends a text, on rank 0. Not collective; a failure is reported by close().
  void append(std::string_view text);

  /// Bytes appended so far; on rank 0. Not collective.
  [[nodiscard]] std::streamoff size() const { return size_; }

  /// Inserts a text after the first `at` bytes, on rank 0. Not collective; a failure is reported by close().
  void insert(std::streamoff at, std::string_view text);

  /// Closes the file. Throws OutputFailure if any part of it could not be written. Collective.
  void close();

private:
  const OutputFolder& folder_;
  std::string name_;
  std::fstream out_; ///< open on rank 0
  std::streamoff size_ = 0;
  int error_ = 0; ///< errno of the first failure
};

} // namespace signorini::io
