// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/analysis.h"
#include "accuracy/fingerprint.h"
#include "accuracy/search_costs.h"
#include "io/folder_lock.h"
#include <filesystem>

namespace signorini::accuracy {

/// The results of a rung in the folder of a study.
struct CachedRung {
  std::optional<Measured> measured; ///< empty if it has to run
  std::string unfit;                ///< why its file cannot be used; empty if there is none
};

/// The result of a search in the folder of a study.
struct CachedSearch {
  std::optional<SearchCost> cost;
  std::string unfit;
};

/// The folder of a study: one file for each rung and search that has run, and the tables of all of them. A
/// later study of the same scene continues from these files. Used on rank 0. Files are replaced as a whole.
/// Throws UserError.
class RungCache {
public:
  /// Creates the folder and locks it for this study.
  explicit RungCache(const std::filesystem::path& folder);
  ~RungCache();

  /// The results of a rung, if its file is intact, has the same fingerprint and all of the wanted quantities.
  [[nodiscard]] CachedRung load(const Rung& rung, const Fingerprint& fingerprint,
                                const std::vector<Quantity>& wanted) const;
  void save(const Rung& rung, const Fingerprint& fingerprint, const Measured& measured) const;

  /// The result of a search to this tolerance, if its file is intact and has the same fingerprint.
  [[nodiscard]] CachedSearch load(double tolerance, const Fingerprint& fingerprint) const;
  void save(const SearchCost& search, const Fingerprint& fingerprint) const;

  /// Writes a text file.
  void write(const std::string& name, const std::string& text) const;
  /// Removes a file of the folder, if it exists.
  void remove(const std::string& name) const;

private:
  [[nodiscard]] std::filesystem::path file(const Rung& rung) const;
  [[nodiscard]] std::filesystem::path file(double tolerance) const;
  std::filesystem::path folder_;
  io::FolderLock lock_;
};

/// study.csv: a row for each rung that has run.
std::string csv(const std::vector<Result>& results, const std::vector<Errors>& errors, double end);

/// study.json: the scene, quantities, orders and sentences, and the number of searches.
std::string json(const scene::Scene& scene, const std::vector<Result>& results, std::size_t searches,
                 const std::vector<Errors>& errors, const std::vector<Orders>& orders,
                 const std::vector<std::string>& sentences);

} // namespace signorini::accuracy
