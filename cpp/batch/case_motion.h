// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/motion_quantities.h"
#include "batch/probe_figures.h"
#include "problem/run_objective.h"
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace signorini::batch {

/// Numbers of a motion by name, in the order of their columns.
using Numbers = std::vector<std::pair<std::string, double>>;

/// Outcome of a case: its numbers, or why it failed.
struct Outcome {
  int steps = 0;
  Numbers numbers{};
  std::string reason{}; ///< empty if the motion was computed
  /// Warnings about the motion: the first message of each kind.
  std::map<std::string, std::string> warnings{};
  bool interrupted = false; ///< whether a request to stop ended it; it then has no numbers
};

/// The motion of one case, with all that it needs of its own.
class CaseMotion {
public:
  /// Sets up the problem of a case. `like`: another case with the same operators_key(), which must outlive
  /// this object; null without. Throws UserError, SolverFailure. The references must outlive this object.
  CaseMotion(std::shared_ptr<const problem::SpaceDiscretisation> discretisation, const scene::Scene& scene,
             const std::vector<std::string>& quantities, const CaseMotion* like);
  CaseMotion(const CaseMotion&) = delete;
  CaseMotion& operator=(const CaseMotion&) = delete;

  /// Computes the motion. Does not throw what concerns this case alone, but returns it as its outcome.
  /// `folder`: folder for all results of the motion, as those of the verb simulate; null: none.
  [[nodiscard]] Outcome run(const std::filesystem::path* folder = nullptr);

  [[nodiscard]] const problem::Problem& problem() const { return problem_; }
  /// Quantities of the numbers, without those of probes.
  [[nodiscard]] const std::vector<accuracy::Quantity>& quantities() const { return wanted_; }

private:
  [[nodiscard]] Outcome motion(const std::filesystem::path* folder);

  Timers timers_;
  scene::Scene scene_;
  problem::Problem problem_;
  problem::GivenControl given_;
  std::vector<accuracy::Quantity> wanted_;
};

/// Quantities of a scene that cases can have: those of study that are numbers. `names`: the wanted ones;
/// empty: all but the stress, energy_loss and restitution, which take two products a step.
/// Throws UserError if a name is unknown or names a field.
std::vector<accuracy::Quantity> case_quantities(const scene::Scene& scene,
                                                const std::vector<std::string>& names, int dim);

} // namespace signorini::batch
