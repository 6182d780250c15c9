// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "diagnostics/contact_forces.h"
#include "fem/stress_recovery.h"
#include "step/load.h"
#include "step/step.h"
#include "trajectory/step_errors.h"
#include "trajectory/time_integrator.h"
#include <optional>
#include <string>
#include <vector>

namespace signorini::diagnostics {

/// Checks whether a contact zone has more than two nodes: the forces of one or two depend on the mesh. The
/// spacing that would put five nodes into it is from Hertz's theory, by the largest force, the curvature of
/// the gap and the stiffest material.
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
    double time = 0;    ///< time of that mean, s
    int candidate = -1; ///< candidate with the largest force then
  };
  [[nodiscard]] Warning warning(int obstacle, const Zone& zone) const;
  /// Whether a flat face touches with all of its two nodes, as that of a bar one element wide.
  [[nodiscard]] bool whole_face(int obstacle, const Zone& zone) const;

  const step::Stepper& stepper_;
  const scene::Scene& scene_;
  std::vector<Zone> zones_; ///< zone of each obstacle
};

/// Spacing of candidates at one of them, and the spacing that would put five or more into the contact zone.
struct Spacing {
  double found = 0, ///< mean distance of the nearest candidates of the same obstacle, m
      enough = 0;   ///< m; 0 at an edge or a corner of the body, where there is none
};

/// Spacing for a zone with `most` candidates around `candidate` that carries `force` (N, in the plane N/m) on
/// a body with the plane-strain modulus E/(1 − ν²) (Pa). Not collective.
Spacing spacing_for(const contact::ContactPairs& pairs, int candidate, int most, double force,
                    double modulus);

/// Counts of candidates in contact and of those that open and close from step to step.
struct Alternations {
  int closed = 0;      ///< candidates in contact, summed over the steps
  int alternating = 0; ///< candidates whose contact differs in a step from that before and after it
};

/// Counts over the steps 1, 2, … of a motion; entry 0 is the initial state, whose candidates count as open.
Alternations alternations(const std::vector<contact::ContactLinearisation>& contact);

/// Advice on how to make contact depend less abruptly on forces: "try …".
std::string calmer_contact(const step::Stepper& stepper);

/// Warns if contact did the work `contact_work` (J, in the plane J/m) in a motion of `largest_energy` though
/// its obstacles are at rest. A step stops at once all mass at the obstacle that a wave reaches within it, at
/// least that of the nodes in contact. Names the step that would do; empty where an obstacle moves. Not
/// collective.
std::vector<Warning> contact_loss(const step::Stepper& stepper, const scene::Scene& scene,
                                  double contact_work, double largest_energy);

/// Checks whether a body and an obstacle could pass through each other within a step, since gaps are
/// evaluated only at the ends of steps. The limit is an approach by more than half the depth of either from
/// where they could touch.
class Passage {
public:
  /// The references must outlive this object.
  explicit Passage(const step::Stepper& stepper);

  /// Takes the frame after the last one, from frame 0 on. Collective.
  void observe(const trajectory::Frame& frame);
  /// A warning for each obstacle that could be passed, for its worst step.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  struct Worst {
    double share = 0, path = 0, depth = 0; ///< path over depth; m
    step::TimeStep step;
  };
  const step::Stepper& stepper_;
  std::optional<contact::ContactPairs::Gaps> now_, before_;
  std::vector<double> gaps_, moved_; ///< gaps, and ν·y, after the last step (m)
  std::vector<Worst> worst_;         ///< worst step of each obstacle
};

/// Warnings about effects that the steps of a motion, or the mesh, may have missed (docs/method.md section
/// 11). Without any, and where a second run with shorter steps agrees, an accuracy is met.
class StepWarnings {
public:
  /// `load`: the scene's, null without; `errors`: step errors of a motion whose steps are chosen while it is
  /// made. Collective. The arguments must outlive this object.
  StepWarnings(const step::Stepper& stepper, const scene::Scene& scene, const step::SceneLoad* load,
               const trajectory::StepErrors* errors = nullptr);

  /// Takes the frames of a motion in turn, from frame 0 on. Collective.
  void observe(const trajectory::Frame& frame);
  /// The warnings at the end of the motion. Collective.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  const step::SceneLoad* load_;
  Passage passage_;
  std::optional<trajectory::StepErrors> own_; ///< errors of steps that were chosen before
  const trajectory::StepErrors* errors_;      ///< null for steps of one length
};

/// Name of the warning of a largest stress that depends on the mesh.
constexpr const char* stress_of_the_mesh = "stress of the mesh";

/// The largest von Mises stress of a motion, and whether the mesh resolves it. A stress at a sharp corner
/// grows without bound as the mesh is refined, and the cells around it then differ much from it.
class LargestStress {
public:
  struct Peak {
    fem::StressPeak stress;
    double time = 0; ///< s
  };

  /// Observes a body of these parts. Collective. `space` must outlive this object.
  LargestStress(const fem::Space& space, std::vector<fem::Part> parts);

  /// Takes the motion at time `t` (s), which was the last one set in `fields`. Collective.
  void observe(fem::CellFields& fields, Vec y, Vec v, double t);

  /// The largest stress so far; absent before a motion was observed. Collective.
  [[nodiscard]] std::optional<Peak> peak();

  /// A warning that names the corner. Collective.
  [[nodiscard]] std::vector<Warning> warnings();

private:
  const fem::Space& space_;
  std::vector<fem::Part> parts_;
  petsc::Vector y_, v_; ///< state of the largest stress so far
  double largest_ = -1, time_ = 0;
  std::optional<Peak> peak_; ///< peak of that state, once computed
};

} // namespace signorini::diagnostics
