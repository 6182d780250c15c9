// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "diagnostics/balance.h"
#include "step/step.h"
#include <array>
#include <limits>
#include <string>
#include <vector>

namespace signorini::diagnostics {

/// Checks whether a motion is within the model's assumptions: small strain, obstacles linearised about the
/// undeformed body, one body. Outside of these the model still gives a result, and no solver detects the
/// violation. Checks only a few frames: the first one in each of `parts` equal parts of the time,
/// the last one, and, if energies are given, the one with the largest elastic energy.
class Plausibility {
public:
  /// Usual number of equal parts of the time, in each of which one frame is checked.
  static constexpr int checked_frames = 16;

  /// Prepares the checks of a motion. `parts`: number of equal parts of the time, in each of which one frame
  /// is checked. Collective. The references must outlive this object.
  Plausibility(const step::Stepper& stepper, const scene::Scene& scene, int parts = checked_frames);

  /// Observes the next frame; frames are passed in order, from frame 0 on. `balance`: null if energies are
  /// not computed. Collective.
  void observe(const trajectory::Frame& frame, const StepBalance* balance);

  /// Returns the warnings at the end of a motion, at most one of each kind. Only the warnings about contact
  /// groups of the mesh are given for each contact table. Collective.
  [[nodiscard]] std::vector<Warning> warnings();

private:
  /// Largest value of a checked quantity so far, even if it is below its limit, with its time (s) and place
  /// (m). `passed`: first checked time at which the limit was exceeded, s; infinite if it was not.
  struct Worst {
    double value = 0, time = 0;
    std::array<double, 3> at{};
    double passed = std::numeric_limits<double>::infinity();
  };

  /// Checks the displacement `y` at time `t` (s).
  void check_displacement(Vec y, double t);
  void check_contact(Vec y, double t);
  /// Checks how far nodes in contact with another part have slid along it.
  void check_slide(Vec y, double t);
  void add_of_mesh(std::vector<Warning>& warnings) const;
  /// Number of the scene's forces at nodes that clamps hold in every direction of the force. Collective.
  [[nodiscard]] int forces_on_clamps() const;
  [[nodiscard]] std::string where(const Worst& worst) const;
  [[nodiscard]] static std::string since(const Worst& worst);

  const step::Stepper& stepper_;
  const scene::Scene& scene_;
  int parts_;
  int checked_parts_ = 0;              ///< number of parts of the time in which a frame has been checked
  petsc::Vector largest_energy_state_; ///< y at the largest elastic energy so far
  double energy_ = 0;
  double largest_energy_time_ = -1; ///< time of largest_energy_state_, s; negative if it need not be checked
  Worst obstacle_turn_;             ///< rotation of an obstacle with mass, rad
  Worst strain_, rotation_, inverted_, slip_, gap_;
  double strain_around_ = 0; ///< mean over the cells around the largest strain, once that is above its limit
  Worst slide_;              ///< tangential jump of two parts in contact, in facets of the slave side
  Worst axis_;               ///< depth of a node on the axis without candidate inside an obstacle, m
  std::vector<double> gaps_; ///< gaps of the constraint rows, m
  std::optional<contact::ContactPairs::Gaps> psi_;
  std::optional<contact::ConstraintRows> jumps_; ///< ContactPairs::jumps(); absent without contact of parts
};

} // namespace signorini::diagnostics
