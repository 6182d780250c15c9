// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "diagnostics/balance.h"
#include "diagnostics/contact_forces.h"
#include "diagnostics/probe_peaks.h"
#include "problem/problem.h"
#include <string>
#include <utility>
#include <vector>

namespace signorini::batch {

/// Reduces what the probes of a motion record to numbers.
class ProbeFigures {
public:
  /// `controlled`: whether a control acts. The problem must have probes and outlive this object. Collective.
  ProbeFigures(const problem::Problem& problem, bool controlled);

  /// Takes the next frame; frames are passed in order, from frame 0 on. Collective.
  void observe(const trajectory::Frame& frame);

  /// Returns least, largest and last value of each column of probes.csv, as `<column>.min`, `.max` and
  /// `.end`, and the peaks of accelerations and filtered forces, as `<probe>.<quantity>.peak`.
  [[nodiscard]] std::vector<std::pair<std::string, double>> numbers() const;

private:
  const diagnostics::Probes& probes_;
  std::optional<diagnostics::Balance> balance_; ///< for the reactions of clamps
  diagnostics::ObstacleForces forces_;
  diagnostics::ProbePeaks peaks_;
  std::vector<double> now_, least_, largest_;
};

} // namespace signorini::batch
