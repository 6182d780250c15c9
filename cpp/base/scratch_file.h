#pragma once
#include "base/hdf5.h"
#include <filesystem>
#include <span>

namespace signorini {

/// Rows of numbers on disk, of this process alone, which are gone when it ends, however it ends: the HDF5
/// file loses its name as soon as it is open. It is in $TMPDIR, else in /var/tmp, since /tmp may be memory.
class ScratchFile {
public:
  /// Throws WriteFailure.
  ScratchFile(std::size_t rows, std::size_t columns);

  /// Throws WriteFailure, where the disk is full for example.
  void write(std::size_t row, std::span<const double> values);
  /// A row that was written. Throws WriteFailure.
  void read(std::size_t row, std::span<double> values) const;

private:
  Opened open();
  [[nodiscard]] Opened row_of(std::size_t row) const;
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path folder_;
  std::size_t rows_, columns_;
  Opened file_, table_, line_; ///< line_: the shape of a row in memory
};

} // namespace signorini
