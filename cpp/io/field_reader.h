// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <filesystem>
#include <string>
#include <vector>

namespace signorini::io {

/// Field that an earlier run stored over time (FieldWriter), on the same mesh and any number of ranks.
class StoredField {
public:
  /// Finds `field` in an HDF5 file and matches its nodes with those of the space by their coordinates. `key`:
  /// the scene's key that names the run; `at_start`: whether runs store the field at t = 0. Collective.
  /// `space` must outlive this object. Throws UserError if the file is missing or damaged, has no such field,
  /// or has it on another mesh or not from 0 to `end` (s).
  StoredField(const fem::Space& space, const std::filesystem::path& file, const std::string& field,
              const std::string& key, double end, bool at_start = true);

  /// Times at which the field is stored, s, ascending.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }

  /// Evaluates the field at time t (s), linear between two stored times, which are cached: cheap for
  /// monotonic t. Before the first time it is the field there. Collective. Throws UserError if its values are
  /// damaged.
  void at(double t, Vec out);

private:
  /// A stored field in memory.
  struct Stored {
    std::size_t number;
    petsc::Vector values;
  };
  [[noreturn]] void fail(const std::string& problem) const;
  void look(double end, bool at_start, std::vector<double>& points);
  Vec stored(std::size_t number);

  const fem::Space& space_;
  std::filesystem::path file_;
  std::string field_, key_;
  std::vector<double> times_;      ///< s, ascending
  std::vector<std::string> names_; ///< datasets; on rank 0
  std::size_t nodes_;              ///< on all ranks
  std::vector<std::size_t> rows_;  ///< rows of the owned nodes in the file
  std::vector<Stored> kept_;       ///< the two around the time last evaluated
};

} // namespace signorini::io
