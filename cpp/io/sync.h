// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <system_error>
#include <unistd.h>

namespace signorini::io {

/// Flushes a file, or a folder's entries, to the disk. Throws filesystem_error.
inline void synchronise(const std::filesystem::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool done = file >= 0 && fsync(file) == 0;
  const std::error_code error(errno, std::generic_category());
  if (file >= 0)
    close(file);
  if (!done)
    throw std::filesystem::filesystem_error("", path, error);
}

} // namespace signorini::io
