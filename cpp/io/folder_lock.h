#pragma once
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace signorini::io {

/// The right to write into a folder, which one process has at a time, and to replace what earlier runs left there. A
/// file of the folder tells other runs who has it; the kernel takes it back when the process ends, however that is.
/// Not collective: of rank 0.
class FolderLock {
public:
  using Names = std::vector<std::string>;

  /// Makes the folder. Throws UserError if that cannot be done or another process has it.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Throws UserError if one of `names` is in the folder and no run put it there: neither is it among the "files" of a
  /// `manifest` that this program wrote (without such a list that stands for all of the names), nor among the `early`
  /// ones of a run that was killed. `early`: what this run puts there before its manifest.
  void claim(const std::string& manifest, const Names& names, const Names& early);

  /// The folder.
  [[nodiscard]] const std::filesystem::path& path() const { return folder_; }

private:
  struct Unlocked {};
  FolderLock(const std::filesystem::path& folder, Unlocked) : folder_(std::filesystem::absolute(folder)) {}
  void make(const std::filesystem::path& given);
  void lock(const std::filesystem::path& given);
  /// Whether the manifest stands for a file.
  [[nodiscard]] bool vouched(const std::string& name) const;

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> made_; ///< folders that did not exist before, innermost first
  int file_ = -1;
  std::string manifest_;
  std::set<std::string> early_; ///< of this run and of killed ones
};

} // namespace signorini::io
