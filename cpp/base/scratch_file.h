// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/hdf5.h"
#include <filesystem>
#include <span>

namespace signorini {

/// Table of numbers on disk, private to this process: an HDF5 file that is unlinked once it is open, so that
/// it is removed however the process ends. It is in $TMPDIR, else in /var/tmp, since /tmp may be in memory.
/// Not collective.
class ScratchFile {
public:
  /// Creates an empty table (rows × columns). Throws WriteFailure.
  ScratchFile(std::size_t rows, std::size_t columns);

  /// Writes one row (columns). Throws WriteFailure, for example if the disk is full.
  void write(std::size_t row, std::span<const double> values);
  /// Reads one row (columns) that was written before. Throws WriteFailure.
  void read(std::size_t row, std::span<double> values) const;

private:
  Hdf5Handle open();
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path folder_;
  std::size_t rows_, columns_;
  Hdf5Handle file_, table_;
};

/// Throws UserError if the folder of TMPDIR, TEMP or TMP is missing and cannot be made, or cannot be written:
/// Open MPI crashes there. Call it before MPI starts.
void require_temporary_folder();

} // namespace signorini
