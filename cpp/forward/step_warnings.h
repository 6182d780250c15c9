// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "forward/load.h"
#include "forward/passage.h"
#include "forward/step_errors.h"

namespace signorini::forward {

/// Warnings of what the steps of a motion, or the mesh, may have missed (docs/method.md section 11): without
/// any, and where a second run with shorter steps agrees, an accuracy is met.
class StepWarnings {
public:
  /// `load`: the scene's, null without; `errors`: those of the steps where they are chosen while the motion
  /// is made. Collective. The arguments must outlive this object.
  StepWarnings(const Stepper& stepper, const scene::Scene& scene, const SceneLoad* load,
               const StepErrors* errors = nullptr);

  /// Takes the frames of a motion in turn, from frame 0 on. Collective.
  void observe(const Frame& frame);
  /// At the end of the motion. Collective.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  const SceneLoad* load_;
  Passage passage_;
  std::optional<StepErrors> own_; ///< of steps that were chosen before
  const StepErrors* errors_;      ///< null for steps of one length
};

} // namespace signorini::forward
