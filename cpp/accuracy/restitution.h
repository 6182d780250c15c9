// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "diagnostics/impact_summary.h"
#include "problem/problem.h"
#include <optional>

namespace signorini::accuracy {

/// Computes the coefficient of restitution of a motion, as simulate stores it in run.json.
class Restitution {
public:
  /// The problem must have contact and outlive this object. Collective.
  explicit Restitution(const problem::Problem& problem);

  /// Takes the next frame with its balance, which `weigh` has made; frames are passed in order, from frame 0
  /// on. Collective.
  void observe(const trajectory::Frame& frame, const diagnostics::StepBalance& balance,
               const diagnostics::Balance& weigh);

  /// Returns the coefficient; absent if the motion so far has none, such as without a rebound.
  [[nodiscard]] std::optional<double> value() const;

private:
  diagnostics::ObstacleForces forces_;
  std::optional<diagnostics::Bodies> bodies_; ///< if parts of the body are in contact
  std::optional<diagnostics::ImpactSummary> summary_;
};

} // namespace signorini::accuracy
