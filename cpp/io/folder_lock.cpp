// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/folder_lock.h"
#include "base/error.h"
#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace signorini::io {
namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr const char* file_name = ".signorini-lock";

/// Reads a JSON file; returns a discarded value if the JSON is not valid.
Json read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return Json::parse(in, nullptr, false);
}

/// Strings in the array `key` of an object; none if the object has no such array.
std::set<std::string> texts(const Json& object, const char* key) {
  std::set<std::string> found;
  if (object.is_object() && object.contains(key) && object[key].is_array())
    for (const Json& text : object[key])
      if (text.is_string())
        found.insert(text.get<std::string>());
  return found;
}

bool present(const fs::path& file) {
  std::error_code none;
  return fs::symlink_status(file, none).type() != fs::file_type::not_found;
}

[[noreturn]] void cannot_write(const fs::path& given, const std::string& reason) {
  throw OutputFailure(
      fmt::format("--out: {} cannot be written ({}); choose another folder", given.string(), reason));
}

std::string last_error() { return std::generic_category().message(errno); }

} // namespace

FolderLock::FolderLock(const fs::path& folder)
    : FolderLock(folder, Unlocked()) { // delegates: the destructor undoes a failed lock
  make(folder);
  lock(folder);
}

void FolderLock::make(const fs::path& given) {
  std::error_code error;
  for (fs::path missing = folder_; !present(missing) && missing.has_relative_path();
       missing = missing.parent_path())
    made_.push_back(missing);
  fs::create_directories(folder_, error);
  if (error)
    cannot_write(given, error.message());
}

void FolderLock::lock(const fs::path& given) {
  const fs::path path = folder_ / file_name;
  for (;;) {
    const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
    if (file < 0)
      cannot_write(given, last_error());
    // Other failures mean a file system without locks: there runs are not kept apart.
    if (flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      close(file);
      const Json holder = read(path);
      const bool known = holder.is_object() && holder.contains("process") && holder.contains("host");
      throw UserError(
          fmt::format("--out: {} is in use by {}; choose another folder", given.string(),
                      known ? fmt::format("process {} on {}", holder["process"].dump(), holder["host"].dump())
                            : "another run that is just starting or ending"));
    }
    struct stat here{}, there{};
    if (fstat(file, &here) == 0 && stat(path.c_str(), &there) == 0 && here.st_ino == there.st_ino) {
      file_ = file;
      break;
    }
    close(file); // its last holder removed it meanwhile
  }
  early_ = texts(read(path), "early");
}

bool FolderLock::listed(const std::string& name) const {
  const Json manifest = read(folder_ / manifest_);
  if (!manifest.is_object() || !manifest.contains("versions") || !manifest["versions"].contains("signorini"))
    return false;
  return !manifest.contains("files") || texts(manifest, "files").contains(name);
}

void FolderLock::claim(const std::string& manifest, const Names& names, const Names& early) {
  manifest_ = manifest;
  for (const std::string& name : names)
    if (present(folder_ / name) && !early_.contains(name) && !listed(name))
      throw UserError(
          fmt::format("--out: {} was not written by a run in that folder; move the file, or choose another "
                      "folder",
                      (folder_ / name).string()));
  early_.insert(early.begin(), early.end());
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  const std::string text = Json{{"process", getpid()}, {"host", host}, {"early", early_}}.dump() + "\n";
  errno = ENOSPC; // for a short write, which sets no errno
  if (ftruncate(file_, 0) != 0 ||
      pwrite(file_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size()))
    cannot_write(folder_, last_error());
}

FolderLock::~FolderLock() {
  if (file_ >= 0) {
    const bool needed = std::ranges::any_of(early_, [&](const std::string& name) {
      return present(folder_ / name) && (manifest_.empty() || !listed(name));
    });
    if (!needed)
      unlink((folder_ / file_name).c_str());
    close(file_);
  }
  std::error_code not_empty;
  for (const fs::path& folder : made_)
    fs::remove(folder, not_empty);
}

} // namespace signorini::io
