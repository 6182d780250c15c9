// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "diagnostics/balance.h"
#include "fem/deformation.h"
#include "step/step.h"
#include <array>
#include <limits>
#include <string>
#include <vector>

namespace signorini::diagnostics {

/// Checks whether a motion is within the model's assumptions: small strain, obstacles linearised about the
/// undeformed body, one body. The model gives a result for any other motion too, and no solver detects that.
/// Checks a few frames, outside of the steps: the first in each of `looks` equal parts of the time, the last,
/// and, if energies are given, that of the largest elastic energy.
class Plausibility {
public:
  /// Number of parts of the time in which a frame is checked.
  static constexpr int looks = 16;

  /// Collective. The references must outlive this object.
  Plausibility(const step::Stepper& stepper, const scene::Scene& scene);

  /// Observes the frame that follows the last one, from frame 0 on; `balance` is null if it is not known.
  /// Collective.
  void observe(const trajectory::Frame& frame, const StepBalance* balance);

  /// The warnings at the end of a motion: one of each kind, of the mesh one for each contact table concerned.
  /// Collective.
  [[nodiscard]] std::vector<Warning> warnings();

private:
  /// The largest value of a kind so far, above the limit or not, with its time and place, and the first
  /// sampled time at which it was above.
  struct Worst {
    double value = 0, time = 0;
    std::array<double, 3> at{};
    double passed = std::numeric_limits<double>::infinity();
  };

  /// Checks a state at time `t` (s).
  void look(Vec y, double t);
  void look_at_contact(Vec y, double t);
  void add_of_mesh(std::vector<Warning>& warnings) const;
  [[nodiscard]] std::string where(const Worst& worst) const;
  [[nodiscard]] static std::string since(const Worst& worst);

  const step::Stepper& stepper_;
  const scene::Scene& scene_;
  int looked_ = 0;         ///< number of parts of the time in which a frame has been checked
  petsc::Vector strained_; ///< y at the largest elastic energy so far
  double energy_ = 0;
  double strained_at_ = -1; ///< s; < 0: never
  Worst strain_, rotation_, inverted_, slip_, gap_;
  std::vector<double> gaps_; ///< (m)
  std::optional<contact::ContactPairs::Gaps> psi_;
};

/// Extent, mass and wave speeds of the body, for spotting unit errors.
struct BodyFigures {
  std::array<double, 3> extent{};         ///< extent of the bounding box, m
  int dim = 0;                            ///< dimension, 2 or 3
  double mass = 0;                        ///< kg, in the plane kg/m
  std::array<double, 2> pressure_waves{}; ///< least and greatest speed over the materials, m/s
  std::array<double, 2> shear_waves{};    ///< least and greatest speed over the materials, m/s
  double crossing = 0;                    ///< time in which the fastest wave crosses the greatest extent, s
  double crossing_steps = 0;              ///< time steps in that time; 0: their length varies
  std::vector<std::string> warnings;      ///< implausible figures, one sentence each
  std::vector<std::string> notes;         ///< interpretation of the mesh, one sentence each; on rank 0 only

  /// The figures in words, without the warnings.
  [[nodiscard]] std::string line() const;
};

/// Figures of the undeformed body of a scene. Collective.
BodyFigures body_figures(const step::Stepper& stepper, const scene::Scene& scene);

} // namespace signorini::diagnostics
