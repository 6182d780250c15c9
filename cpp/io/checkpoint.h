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

/// Writes numbers, texts and controls by name into an HDF5 file that commit() puts in place as a whole, on
/// any number of ranks; every chunk has a checksum. All members collective; rank 0 writes, and a failure
/// there is reported by commit() alone.
class CheckpointWriter {
public:
  /// Opens `part` for a search without controls; commit() renames it to `file`, on the same disk.
  CheckpointWriter(MPI_Comm comm, const std::filesystem::path& part, const std::filesystem::path& file);
  /// Opens `part` for a search with `controls`.
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

  /// Puts the file in place. Returns the reason of a failure, empty without one.
  [[nodiscard]] std::string commit();

private:
  template <class Sequence>
  void put(const std::string& name, hid_t stored, const Sequence& values);
  void write(const std::string& name, const control::Control& u);

  MPI_Comm comm_;
  std::filesystem::path part_, file_;
  std::vector<int> counts_, starts_; ///< number and start of each rank's values in a row
  Hdf5Handle out_;                   ///< on rank 0
  std::string failure_;              ///< on rank 0
};

/// Text of a checkpoint; empty if there is no such file or text. Collective.
[[nodiscard]] std::string checkpoint_text(MPI_Comm comm, const std::filesystem::path& file,
                                          const std::string& name);

/// Numbers of a checkpoint; empty if there is no such file or entry. Collective.
[[nodiscard]] std::vector<double> checkpoint_numbers(MPI_Comm comm, const std::filesystem::path& file,
                                                     const std::string& name);

/// Reads files of CheckpointWriter, on any number of ranks. All members collective; all throw UserError where
/// the file is missing or damaged.
class CheckpointReader {
public:
  /// Opens a checkpoint. `reason`: option or key that requires the file, for messages. The file's controls
  /// are only read with `controls`, which must outlive this object.
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

  /// Whether the file has an entry of that name.
  [[nodiscard]] bool has(const std::string& name) const;

  /// Reads a control of other intervals: interval j gets the values of the row `row(j, rows)` of `rows`.
  [[nodiscard]] control::Control control(const std::string& name,
                                         const std::function<int(int j, int rows)>& row);

  /// Matches the places of the controls with those of the file by coordinates; to be called before the first
  /// control is read. Throws UserError if they differ.
  void match_places();
  /// Matches the places like match_places(); returns false if they differ or are damaged.
  [[nodiscard]] bool matches_places();

  /// Throws UserError with the file's name and `problem`.
  [[noreturn]] void fail(const std::string& problem) const;

private:
  /// Reads a control with as many rows as the controls have.
  control::Control control(const std::string& name);
  [[noreturn]] void damaged(const std::string& name) const;
  template <class Sequence>
  void read(const std::string& name, Sequence& values);

  MPI_Comm comm_;
  const control::ControlSpace* controls_ = nullptr;
  std::filesystem::path file_;
  std::string reason_;
  Hdf5Handle in_;                 ///< on rank 0
  std::size_t columns_ = 0;       ///< values in a row, of all ranks
  std::vector<std::size_t> rows_; ///< rows of the owned places in the file
};

} // namespace signorini::io
