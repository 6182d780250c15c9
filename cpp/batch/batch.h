// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "batch/results.h"
#include <functional>
#include <mpi.h>

namespace signorini::batch {

/// Options of the verb batch.
struct Options {
  std::filesystem::path cases;         ///< table of the cases, CSV
  std::vector<std::string> quantities; ///< wanted numbers; empty: default of case_quantities()
  bool resume = false;                 ///< whether outcomes in the folder are kept
  std::optional<Shard> shard;          ///< part of the table to compute; absent: all
  bool folders = false;                ///< whether each case has a folder with all results of its motion
  int together = 16;                   ///< largest number of motions whose solves are made together
};

/// Parses the scene with these changes (`key.path=value`). Throws UserError. Collective.
using ParseScene = std::function<scene::Scene(const std::vector<std::string>& overrides)>;

/// Runs the verb batch: computes the motions of all cases of a table and writes their numbers to cases.csv in
/// `out`. Each rank computes cases of its own, in blocks that share a factorisation. A case that fails has a
/// row with its reason. Returns the exit status: 130 if interrupted, with the outcomes so far written; 3 if
/// every case failed. Throws UserError. Collective.
int run_batch(MPI_Comm comm, const scene::Scene& scene, const ParseScene& parse,
              const std::filesystem::path& out, const Options& options, const Console& console);

} // namespace signorini::batch
