// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "diagnostics/passage.h"
#include "step/load.h"
#include "trajectory/step_errors.h"

namespace signorini::diagnostics {

/// Warnings of what the steps of a motion, or the mesh, may have missed (docs/method.md section 11): without
/// any, and where a second run with shorter steps agrees, an accuracy is met.
class StepWarnings {
public:
  /// `load`: the scene's, null without; `errors`: those of the steps where they are chosen while the motion
  /// is made. Collective. The arguments must outlive this object.
  StepWarnings(const step::Stepper& stepper, const scene::Scene& scene, const step::SceneLoad* load,
               const trajectory::StepErrors* errors = nullptr);

  /// Takes the frames of a motion in turn, from frame 0 on. Collective.
  void observe(const trajectory::Frame& frame);
  /// At the end of the motion. Collective.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  const step::SceneLoad* load_;
  Passage passage_;
  std::optional<trajectory::StepErrors> own_; ///< of steps that were chosen before
  const trajectory::StepErrors* errors_;      ///< null for steps of one length
};

} // namespace signorini::diagnostics
