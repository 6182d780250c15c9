// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/hdf5.h"
#include <filesystem>
#include <span>

namespace signorini {

/// Table of doubles on disk, private to this process: an HDF5 file in $TMPDIR or, if that is not set, in
/// /var/tmp, since /tmp may be in memory. The file is unlinked as soon as it is open, so that it disappears
/// however the process ends. Not collective.
class ScratchFile {
public:
  /// Creates an empty table (rows × columns). Throws WriteFailure.
  ScratchFile(std::size_t rows, std::size_t columns);

  /// Writes one row (columns). Throws WriteFailure if that fails, for example because the disk is full.
  void write(std::size_t row, std::span<const double> values);
  /// Reads one row (columns) that write() has written. Throws WriteFailure if that fails.
  void read(std::size_t row, std::span<double> values) const;

private:
  Hdf5Handle open();
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path folder_;
  std::size_t rows_, columns_;
  Hdf5Handle file_, table_;
};

/// Creates the folder named by TMPDIR, TEMP or TMP if necessary. Throws UserError if that fails or the folder
/// is not writable, for Open MPI would crash. Call this function before MPI starts.
void require_temporary_folder();

} // namespace signorini
