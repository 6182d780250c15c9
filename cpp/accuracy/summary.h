// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/analysis.h"
#include "accuracy/rung_cache.h"
#include "base/progress.h"

namespace signorini::accuracy {

/// Writes and prints the results of a study's rungs that have run; tables on the console have at most 80
/// columns. Used on rank 0.
class Summary {
public:
  /// Computes errors, orders and sentences from the results. The references must outlive this object.
  Summary(const scene::Scene& scene, const std::vector<Quantity>& wanted,
          const std::vector<RungResult>& results, const std::vector<SearchCost>& searches,
          const Exact& exact);

  /// Writes the results into the folder of the study.
  void write(const RungCache& store) const;
  /// Prints the results.
  void show(const Console& console) const;

private:
  /// Text of a rung's size; "~" marks graded meshes.
  [[nodiscard]] static std::string size(const RungResult& result);
  /// Text of the length of a rung's steps or, for steps of varying length, of their tolerance.
  [[nodiscard]] std::string step(const RungResult& result) const;
  void show_rungs(const Console& console) const;
  void show_warnings(const Console& console) const;
  void show_errors(const Errors& errors, const Console& console) const;
  void show_orders(const Console& console) const;
  void show_searches(const Console& console) const;

  const scene::Scene& scene_;
  const std::vector<RungResult>& results_;
  const std::vector<SearchCost>& searches_;
  std::vector<Errors> errors_;
  std::vector<Orders> orders_;
  std::vector<std::string> sentences_;
};

} // namespace signorini::accuracy
