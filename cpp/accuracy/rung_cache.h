// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/analysis.h"
#include "accuracy/fingerprint.h"
#include "accuracy/search_costs.h"
#include "io/folder_lock.h"
#include <filesystem>

namespace signorini::accuracy {

/// Results of a rung, loaded from the folder of a study.
struct CachedRung {
  std::optional<Measured> measured; ///< the results; absent if the rung has to run
  std::string unfit;                ///< why the rung's file cannot be used; empty if it is usable or missing
};

/// Result of a search, loaded from the folder of a study.
struct CachedSearch {
  std::optional<SearchCost> cost; ///< the result; absent if the search has to run
  std::string unfit;              ///< why the search's file cannot be used; empty if it is usable or missing
};

/// Folder of a study: a file for each rung and search that has run, and tables of all results. A later study
/// of the same scene continues from these files. Each file is replaced atomically, so that an interruption
/// leaves the old file or the new one. Used on rank 0. All members
/// throw UserError.
class RungCache {
public:
  /// Creates the folder and locks it for this study.
  explicit RungCache(const std::filesystem::path& folder);
  ~RungCache();

  /// Loads the results of a rung, if the rung's file is undamaged, has this fingerprint, and has all `wanted`
  /// quantities.
  [[nodiscard]] CachedRung load(const Rung& rung, const Fingerprint& fingerprint,
                                const std::vector<Quantity>& wanted) const;
  void save(const Rung& rung, const Fingerprint& fingerprint, const Measured& measured) const;

  /// Loads the result of a search to this tolerance, if the search's file is undamaged and has this
  /// fingerprint.
  [[nodiscard]] CachedSearch load(double tolerance, const Fingerprint& fingerprint) const;
  void save(const SearchCost& search, const Fingerprint& fingerprint) const;

  /// Writes a text file into the folder.
  void write(const std::string& name, const std::string& text) const;
  /// Removes a file of the folder, if it exists.
  void remove(const std::string& name) const;

private:
  [[nodiscard]] std::filesystem::path file(const Rung& rung) const;
  [[nodiscard]] std::filesystem::path file(double tolerance) const;
  std::filesystem::path folder_;
  io::FolderLock lock_;
};

/// Text of study.csv: a row for each rung of a study of `scene` that has run.
std::string csv(const scene::Scene& scene, const std::vector<RungResult>& results,
                const std::vector<Errors>& errors);

/// Text of study.json: scene, quantities and orders of a study, its conclusions in words (`sentences`), and
/// the number of its searches.
std::string json(const scene::Scene& scene, const std::vector<RungResult>& results, std::size_t searches,
                 const std::vector<Errors>& errors, const std::vector<Orders>& orders,
                 const std::vector<std::string>& sentences);

} // namespace signorini::accuracy
