// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "diagnostics/contact_forces.h"
#include "step/load.h"
#include "step/step.h"
#include "trajectory/step_errors.h"
#include "trajectory/time_integrator.h"
#include <optional>
#include <string>
#include <vector>

namespace signorini::diagnostics {

/// Checks whether a contact zone has more than two nodes; forces on one or two nodes depend on the mesh. Also
/// estimates the node spacing that would put five nodes into the zone, by Hertz's theory from the largest
/// force, the curvature of the gap and the stiffest material.
class ContactResolution {
public:
  /// Prepares the check for each obstacle of `scene`. The references must outlive this object.
  ContactResolution(const step::Stepper& stepper, const scene::Scene& scene);

  /// Takes the next frame and its contact forces; frames are passed in order, from frame 0 on. Not
  /// collective.
  void observe(const trajectory::Frame& frame, const ObstacleForces& forces);

  /// Returns a warning for each obstacle that one or two nodes touched, but never more at once, unless these
  /// are a whole face (whole_face()). Not collective.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  struct Zone {
    int most = 0;       ///< largest number of candidates in contact at once
    double last = 0;    ///< normal force of the last step, N; in plane strain and plane stress N/m
    double force = 0;   ///< largest mean of the normal force over two steps in a row, as `last`
    double time = 0;    ///< time of that mean, s
    int candidate = -1; ///< candidate with the largest force at that time; −1: no force so far
  };
  [[nodiscard]] Warning warning(int obstacle, const Zone& zone) const;
  /// Returns whether all candidates of the obstacle, at least two and with equal initial gaps, touch at once.
  /// An example is the end face of a bar that is one element wide.
  [[nodiscard]] bool whole_face(int obstacle, const Zone& zone) const;

  const step::Stepper& stepper_;
  const scene::Scene& scene_;
  std::vector<Zone> zones_; ///< contact zone of each obstacle
};

/// Spacing of candidates around one candidate, and the spacing that would put five or more into the contact
/// zone.
struct CandidateSpacing {
  double found = 0, ///< mean distance to the nearest candidates of the same obstacle, m
      enough = 0;   ///< spacing for five or more, m; 0 if no spacing suffices, as at an edge of the body or
                    ///< an end of the contact group that is no lowest point of a round face
};

/// Returns the present and the sufficient spacing for a contact zone of `most` candidates around `candidate`.
/// The zone carries `force` (N; in plane strain and plane stress N/m) on a body with the plane-strain modulus
/// E/(1 − ν²) = `modulus` (Pa). Not collective.
CandidateSpacing candidate_spacing(const contact::ContactPairs& pairs, int candidate, int most, double force,
                                   double modulus);

/// Counts of candidates in contact, and of candidates that open and close from step to step.
struct Alternations {
  int closed = 0;      ///< number of candidates in contact, summed over the steps
  int alternating = 0; ///< number of candidates, summed over the steps, that are open in a step but
                       ///< closed in the steps before and after it, or the reverse
};

/// Returns the counts over the steps 1, 2, … of a motion. Entry 0 of `contact` is the initial state, whose
/// candidates count as open.
Alternations alternations(const std::vector<contact::ContactLinearisation>& contact);

/// Returns advice, "try …", on how to make contact depend less abruptly on forces.
std::string calmer_contact(const step::Stepper& stepper);

/// Returns a warning if contact took more than 3 % of the largest energy of a motion although its obstacles
/// are at rest. `contact_work`: work of contact, `largest_energy`: largest energy, both in J or J/m of
/// depth. Such a loss is a discretisation error: in one step, contact stops all mass that a wave from the
/// obstacle reaches in this step, and at least the mass of the nodes in contact. The warning names the step
/// length below which shorter steps no longer reduce this error. Empty if an obstacle moves. Not collective.
std::vector<Warning> contact_loss(const step::Stepper& stepper, const scene::Scene& scene,
                                  double contact_work, double largest_energy);

/// Checks whether the body and an obstacle could pass through each other within a step, since gaps are
/// evaluated only at the ends of steps. This is assumed possible if they approach each other in one step by
/// more than their gap, and by more than half the depth of the thinner one.
class Passage {
public:
  /// Prepares the check for each obstacle of `stepper`, which must outlive this object.
  explicit Passage(const step::Stepper& stepper);

  /// Takes the next frame; frames are passed in order, from frame 0 on. Collective.
  void observe(const trajectory::Frame& frame);
  /// Returns, for each obstacle that fails the check, a warning about its worst step.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  struct Worst {
    double share = 0, path = 0, depth = 0; ///< ratio of approach to depth; approach, m; depth, m
    step::TimeStep step;
  };
  const step::Stepper& stepper_;
  std::optional<contact::ContactPairs::Gaps> now_, before_;
  std::vector<double> gaps_, moved_; ///< gaps and ν·y after the last step, m
  std::vector<Worst> worst_;         ///< worst step of each obstacle
};

/// Warnings about effects that the steps of a motion, or the mesh, may have missed (docs/method.md section
/// 11). An accuracy counts as met only without such warnings, and if a second run with shorter steps agrees.
class StepWarnings {
public:
  /// `load`: the scene's loads, null without any. `errors`: step errors of a motion whose steps are chosen
  /// while it is integrated. Collective. The arguments must outlive this object.
  StepWarnings(const step::Stepper& stepper, const scene::Scene& scene, const step::SceneLoad* load,
               const trajectory::StepErrors* errors = nullptr);

  /// Takes the next frame; frames are passed in order, from frame 0 on. Collective.
  void observe(const trajectory::Frame& frame);
  /// Returns the warnings at the end of the motion. Collective.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  const step::SceneLoad* load_;
  MPI_Comm comm_;
  int several_ = 0;          ///< number of steps with several solutions (rank 0)
  double first_several_ = 0; ///< end of the first of them, s
  Passage passage_;
  std::optional<trajectory::StepErrors> own_; ///< errors of steps that an earlier motion chose
  const trajectory::StepErrors* errors_;      ///< errors to warn of, given or *own_; null for equal steps
};

} // namespace signorini::diagnostics
