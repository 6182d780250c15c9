// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <filesystem>
#include <string>
#include <vector>

namespace signorini::io {

/// File in which a run stored the fields of this name ("state", "control" or "adjoint"): its HDF5 file or, in
/// a folder without XDMF files, its VTKHDF file. The file may be missing. Not collective.
std::filesystem::path fields_file(const std::filesystem::path& folder, const std::string& name);

/// Field that an earlier run stored over time with FieldWriter. The run must have used the same mesh; its
/// number of ranks may differ.
class StoredField {
public:
  /// Finds `field` in an HDF5 file and matches the file's nodes with those of the space by their coordinates.
  /// `key`: the scene's key that names the run, for messages. `end`: end of the motion, s. `at_start`:
  /// whether the field must be stored at t = 0 too. Throws UserError if the file is missing or damaged, if
  /// the field is missing, is on another mesh or does not cover the motion, or if the space has degree 2.
  /// `space` must outlive this object. Collective.
  StoredField(const fem::Space& space, const std::filesystem::path& file, const std::string& field,
              const std::string& key, double end, bool at_start = true);

  /// Times at which the field is stored, s, ascending.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }

  /// Evaluates the field at time t (s) into `out`, by linear interpolation between two stored times. If t is
  /// outside of the stored times, `out` becomes the field at the nearest stored time. The last two fields
  /// read are cached, so that monotonic t is cheap. Throws UserError if stored values are damaged.
  /// Collective.
  void at(double t, Vec out);

private:
  /// The field at one stored time, in memory.
  struct Stored {
    std::size_t number; ///< index of the time in times_
    petsc::Vector values;
  };
  [[noreturn]] void fail(const std::string& problem) const;
  void look(double end, bool at_start, std::vector<double>& points);
  Vec stored(std::size_t number);

  const fem::Space& space_;
  std::filesystem::path file_;
  std::string field_, key_;
  std::vector<double> times_;      ///< stored times, s, ascending
  std::vector<std::string> names_; ///< dataset name for each time; empty on ranks other than 0
  std::size_t nodes_;              ///< number of nodes, summed over the ranks
  std::vector<std::size_t> rows_;  ///< for each node that this rank owns, the node's row in the file
  std::vector<Stored> kept_;       ///< cache: at most two fields, those around the time last evaluated
};

} // namespace signorini::io
