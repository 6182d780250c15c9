// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace signorini::io {

/// Lock on a folder, so that only one process writes into the folder and replaces the files of earlier runs.
/// A lock file in the folder names the process. The kernel releases the lock when the process ends, even if
/// it is killed. Not collective: used on rank 0.
class FolderLock {
public:
  using Names = std::vector<std::string>;

  /// Creates and locks the folder. Throws OutputFailure if the folder cannot be written, UserError if another
  /// process has the lock.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Throws UserError if the folder has a file with one of the `names` that was not written by a run. A file
  /// counts as written by a run if the folder's `manifest` lists it under "files" or has no such list, or if
  /// it is an early file of a killed run. `early`: files that this run writes before its manifest; the lock
  /// file records them. Throws OutputFailure if the lock file cannot be written.
  void claim(const std::string& manifest, const Names& names, const Names& early);

  /// Absolute path of the folder.
  [[nodiscard]] const std::filesystem::path& path() const { return folder_; }

private:
  struct Unlocked {};
  FolderLock(const std::filesystem::path& folder, Unlocked) : folder_(std::filesystem::absolute(folder)) {}
  void make(const std::filesystem::path& given);
  void lock(const std::filesystem::path& given);
  /// Whether the manifest in the folder lists the file, or has no list.
  [[nodiscard]] bool listed(const std::string& name) const;

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> made_; ///< folders that the constructor created, innermost first
  int file_ = -1;                           ///< descriptor of the lock file; −1: none
  std::string manifest_;                    ///< file name of the manifest
  std::set<std::string> early_;             ///< early files of this run and of killed ones
};

} // namespace signorini::io
