// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/analysis.h"
#include "accuracy/rung_cache.h"
#include "base/progress.h"

namespace signorini::accuracy {

/// Results of the rungs that have run, as files and on the console, in tables of at most 80 columns. Used on
/// rank 0.
class Summary {
public:
  /// The references must outlive this object.
  Summary(const scene::Scene& scene, const std::vector<Quantity>& wanted, const std::vector<Result>& results,
          const std::vector<SearchCost>& searches, const Exact& exact);

  void write(const RungCache& store) const;
  void show(const Console& console) const;

private:
  /// Size of a rung as text; "~" marks sizes that vary.
  [[nodiscard]] static std::string size(const Result& result);
  /// The length of a rung's steps, or the tolerance by which they were chosen.
  [[nodiscard]] std::string step(const Result& result) const;
  void show_rungs(const Console& console) const;
  void show_warnings(const Console& console) const;
  void show_errors(const Errors& errors, const Console& console) const;
  void show_orders(const Console& console) const;
  void show_searches(const Console& console) const;

  const scene::Scene& scene_;
  const std::vector<Result>& results_;
  const std::vector<SearchCost>& searches_;
  std::vector<Errors> errors_;
  std::vector<Orders> orders_;
  std::vector<std::string> sentences_;
};

} // namespace signorini::accuracy
