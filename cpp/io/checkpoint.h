// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/hdf5.h"
#include "control/control_space.h"
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace signorini::io {

/// Writes numbers, texts and controls by name into an HDF5 file, which commit() puts in place as a whole.
/// Every chunk of the file has a checksum. The file does not depend on the number of ranks. All members are
/// collective. Rank 0 writes; only commit() reports a failure to write.
class CheckpointWriter {
public:
  /// Creates the temporary file `part` for a search without controls. commit() renames it to `file`, which
  /// must be on the same disk.
  CheckpointWriter(MPI_Comm comm, const std::filesystem::path& part, const std::filesystem::path& file);
  /// Creates the temporary file `part` for a search with `controls`, whose points it stores.
  CheckpointWriter(const control::ControlSpace& controls, const std::filesystem::path& part,
                   const std::filesystem::path& file);
  ~CheckpointWriter();
  CheckpointWriter(const CheckpointWriter&) = delete;
  CheckpointWriter& operator=(const CheckpointWriter&) = delete;

  void operator()(const std::string& name, double value);
  void operator()(const std::string& name, const std::vector<double>& values);
  void operator()(const std::string& name, const std::string& text);
  void operator()(const std::string& name, const std::shared_ptr<const control::Control>& u);
  void operator()(const std::string& name, const control::CompactControl& u);

  /// Flushes the file to the disk and renames it to its final name. Returns the reason of the first failure
  /// to write, on all ranks; empty if there was none. Collective.
  [[nodiscard]] std::string commit();

private:
  template <class Sequence>
  void put(const std::string& name, hid_t stored, const Sequence& values);
  void write(const std::string& name, const control::Control& u);

  MPI_Comm comm_;
  std::filesystem::path part_, file_;
  std::vector<int> counts_, starts_; ///< number of each rank's values in a row, and index of its first value
  Hdf5Handle out_;                   ///< the temporary file; on rank 0
  std::string failure_;              ///< reason of the first failure, empty without one; on rank 0
};

/// Reads the text `name` from a checkpoint; empty if the file or the entry is missing or damaged. Collective.
[[nodiscard]] std::string checkpoint_text(MPI_Comm comm, const std::filesystem::path& file,
                                          const std::string& name);

/// Reads the numbers `name` from a checkpoint; empty if the file or the entry is missing or damaged.
/// Collective.
[[nodiscard]] std::vector<double> checkpoint_numbers(MPI_Comm comm, const std::filesystem::path& file,
                                                     const std::string& name);

/// Reads a checkpoint that CheckpointWriter wrote, on any number of ranks. All members are collective. Those
/// that read entries throw UserError if the file or an entry is missing or damaged.
class CheckpointReader {
public:
  /// Opens a checkpoint. `reason`: option or key that requires the file, for messages. Reading controls needs
  /// the constructor with `controls`, which must outlive this object. Throws UserError.
  CheckpointReader(MPI_Comm comm, const std::filesystem::path& file, std::string reason = "--resume");
  CheckpointReader(const control::ControlSpace& controls, const std::filesystem::path& file,
                   std::string reason = "--resume");

  void operator()(const std::string& name, double& value);
  void operator()(const std::string& name, int& value);
  void operator()(const std::string& name, bool& value);
  void operator()(const std::string& name, std::vector<double>& values);
  void operator()(const std::string& name, std::string& text);
  void operator()(const std::string& name, std::shared_ptr<const control::Control>& u);
  void operator()(const std::string& name, control::CompactControl& u);

  /// Whether the file has an entry `name`.
  [[nodiscard]] bool has(const std::string& name) const;

  /// Reads a control whose time intervals may differ from the file's. Interval j, counted from 1, gets the
  /// values of the file's row `row(j, rows)`, counted from 0; `rows` is the number of rows in the file. Needs
  /// a preceding match_places().
  [[nodiscard]] control::Control control(const std::string& name,
                                         const std::function<int(int j, int rows)>& row);

  /// Matches the places (nodes or cells) of the controls with those of the file by coordinates. Must be
  /// called before the first control is read. Throws UserError if the places differ.
  void match_places();
  /// Matches the places like match_places(), but returns false if they differ or are damaged in the file.
  [[nodiscard]] bool matches_places();

  /// Throws UserError with the reason for reading, the file's name and `problem`.
  [[noreturn]] void fail(const std::string& problem) const;

private:
  /// Reads a control; throws UserError unless the file has one row for each interval of the controls.
  control::Control control(const std::string& name);
  [[noreturn]] void damaged(const std::string& name) const;
  template <class Sequence>
  void read_entry(const std::string& name, Sequence& values);

  MPI_Comm comm_;
  const control::ControlSpace* controls_ = nullptr;
  std::filesystem::path file_;
  std::string reason_;
  Hdf5Handle in_;                          ///< the open file; on rank 0
  std::size_t columns_ = 0;                ///< number of values of a control in one interval, on all ranks
  std::vector<std::size_t> place_in_file_; ///< for each place that this rank owns, its index in the file
};

} // namespace signorini::io
