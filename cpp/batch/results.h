// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/quantities.h"
#include "batch/case_motion.h"
#include "io/folder_lock.h"
#include "scene/case_table.h"
#include <filesystem>
#include <map>
#include <optional>

namespace signorini::batch {

/// Part of a table's cases, for jobs that share it: number `index` of `count`, from 1.
struct Shard {
  int index = 1, count = 1;
};

/// Outcomes of cases in the folder of a batch, on rank 0: cases.csv, a row for each case that has ended,
/// scene.toml and batch.json. Each file is replaced as a whole, so that an interruption leaves the old or the
/// new one.
class Results {
public:
  /// Creates and locks the folder. `scene`: that of the cases, written as scene.toml; `origin`: digest of all
  /// that determines an outcome besides its row. The references must outlive this object. Throws UserError.
  Results(const std::filesystem::path& folder, const scene::Scene& scene, const scene::CaseTable& table,
          std::string origin, std::optional<Shard> shard);

  /// Takes the outcomes of the same cases from the folder and, without a shard of its own, from those of the
  /// shards within it. Returns how many. Throws UserError if a folder has outcomes of another scene.
  std::size_t resume();

  [[nodiscard]] bool has(std::size_t i) const { return outcomes_[i].has_value(); }
  void set(std::size_t i, Outcome outcome) { outcomes_[i] = std::move(outcome); }
  void set(const std::vector<accuracy::Quantity>& quantities);
  /// Sets the number of dimensions, with which scene.toml is written.
  void set_dim(int dim) { dim_ = dim; }
  /// Number of cases with an outcome, and of those that failed.
  [[nodiscard]] std::size_t ended() const;
  [[nodiscard]] std::size_t failed() const;
  /// Lines on what went wrong: each reason of failed cases and each kind of warning with the first case that
  /// has it and the number of cases, most frequent first; at most `most` of both.
  [[nodiscard]] std::vector<std::string> trouble_lines(std::size_t most) const;

  /// Replaces the files. `seconds`: time of the batch so far; `blocks`: sizes of the blocks of this run.
  void write(double seconds, const std::vector<std::size_t>& blocks) const;

private:
  std::size_t take(const std::filesystem::path& folder);
  [[nodiscard]] std::string table_text() const;
  /// A message with the cases that have it.
  struct Trouble {
    std::string kind, message; ///< message of the first case
    std::size_t first = 0, cases = 0;
  };
  /// Reasons of failed cases or, if `warnings`, the warnings about motions by kind, most frequent first.
  [[nodiscard]] std::vector<Trouble> troubles(bool warnings) const;

  std::filesystem::path folder_;
  io::FolderLock lock_;
  const scene::Scene& scene_;
  const scene::CaseTable& table_;
  std::string origin_;
  std::optional<int> dim_; ///< absent before a mesh was read
  std::optional<Shard> shard_;
  std::vector<std::optional<Outcome>> outcomes_; ///< of the cases of the table
  std::map<std::string, accuracy::Quantity> quantities_;
};

/// Outcomes as text, and back, to pass them between ranks.
std::string packed(const std::vector<std::pair<std::size_t, Outcome>>& outcomes);
std::vector<std::pair<std::size_t, Outcome>> unpacked(const std::string& text);

} // namespace signorini::batch
