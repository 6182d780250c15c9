// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "diagnostics/obstacle_forces.h"

namespace signorini::diagnostics {

/// Checks whether a contact zone has more than a node or two, whose forces depend on the mesh. The
/// spacing that would put five nodes into it comes from Hertz's theory, by the largest force, the curvature
/// of the gap and the stiffest material.
class ContactResolution {
public:
  /// The references must outlive this object.
  ContactResolution(const step::Stepper& stepper, const scene::Scene& scene);

  /// Takes the frame after the last one, from frame 0 on, and its contact forces. Not collective.
  void observe(const trajectory::Frame& frame, const ObstacleForces& forces);

  /// A warning for each obstacle that one or two nodes at most touched at once. Not collective.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  struct Zone {
    int most = 0;       ///< candidates in contact at once
    double last = 0;    ///< force of the last step, N, in the plane N/m
    double force = 0;   ///< the largest mean of two steps in a row, N or N/m
    double time = 0;    ///< of that, s
    int candidate = -1; ///< with the largest force then
  };
  [[nodiscard]] Warning warning(int obstacle, const Zone& zone) const;
  /// Whether a flat face touches with all of its two nodes, as that of a bar one element wide.
  [[nodiscard]] bool whole_face(int obstacle, const Zone& zone) const;

  const step::Stepper& stepper_;
  const scene::Scene& scene_;
  std::vector<Zone> zones_; ///< of each obstacle
};

/// The spacing of candidates at one of them, and what would put five or more of them into the contact zone.
struct Spacing {
  double found = 0, ///< mean distance of the nearest candidates of the same obstacle, m
      enough = 0;   ///< m; 0 at an edge or a corner of the body, where there is none
};

/// For a zone with `most` candidates around `candidate` that carries `force` (N, in the plane N/m) on a body
/// with the plane-strain modulus E/(1 − ν²) (Pa). Not collective.
Spacing spacing_for(const contact::ContactPairs& pairs, int candidate, int most, double force,
                    double modulus);

} // namespace signorini::diagnostics
