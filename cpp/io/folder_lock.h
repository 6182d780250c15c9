// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace signorini::io {

/// Exclusive right of a process to write into a folder and to replace the files of earlier runs there. A lock
/// file in the folder names the process; the kernel releases the lock when the process ends, even if it is
/// killed. Not collective: used on rank 0.
class FolderLock {
public:
  using Names = std::vector<std::string>;

  /// Creates and locks the folder. Throws UserError if that fails or another process has the lock.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Throws UserError if the lock file cannot be written, or if one of `names` is in the folder and no run
  /// wrote it. A run wrote the files in the list "files" of its `manifest`, all names if there is no list,
  /// and a killed run its `early` ones. `early`: the files that this run puts there before its manifest.
  void claim(const std::string& manifest, const Names& names, const Names& early);

  /// The folder.
  [[nodiscard]] const std::filesystem::path& path() const { return folder_; }

private:
  struct Unlocked {};
  FolderLock(const std::filesystem::path& folder, Unlocked) : folder_(std::filesystem::absolute(folder)) {}
  void make(const std::filesystem::path& given);
  void lock(const std::filesystem::path& given);
  /// Whether a run wrote the file, according to the manifest.
  [[nodiscard]] bool listed(const std::string& name) const;

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> made_; ///< folders that did not exist before, innermost first
  int file_ = -1;
  std::string manifest_;
  std::set<std::string> early_; ///< early files of this run and of killed ones
};

} // namespace signorini::io
