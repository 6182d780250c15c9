// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "fem/rigid_motions.h"
#include "trajectory/impulse_record.h"
#include "trajectory/time_integrator.h"
#include <array>
#include <optional>
#include <vector>

namespace signorini::trajectory {

/// Kind of the warning that the peak force depends on the mesh.
constexpr const char* peak_of_the_mesh = "peak of the mesh";

/// Estimates the local errors of a motion in automatic steps from its displacements and contact forces, and
/// the scales of these errors (docs/method.md section 11). A uniform velocity of the body does not change the
/// estimates.
class StepErrors {
public:
  /// Prepares the estimates for the body and contact of `stepper`. Collective. The references must outlive
  /// this object.
  StepErrors(const step::Stepper& stepper, const scene::Scene& scene);

  /// Starts a motion from its displacement and velocity at t_0. Collective.
  void start(Vec y, Vec v);

  /// Error estimates of one step.
  struct Step {
    double error = 0; ///< e without its rounding error, in the unit of scale(); 0 for the shortest steps
    double force_curvature = 0; ///< |second difference|/6 of F̄, the mean normal force over two steps, N
    bool touches = false;       ///< whether the step touches an obstacle that was not in contact before
  };
  /// Estimates the errors of the step after the last accepted one. Collective.
  Step judge(const Frame& frame);
  /// Accepts the step that was judged last. Collective.
  void accept(const Frame& frame);

  /// Judges and accepts the next frame of a motion whose steps are given; frames are passed in order, from
  /// frame 0 on. Collective.
  void observe(const Frame& frame);

  /// Replaces the mean velocities of the last two steps by those between three displacements, which are
  /// `apart` (s) from each other, the last one at time `t` (s). A following longer step is then judged by
  /// means over times of its own length.
  void coarsen(double t, double apart, Vec last, Vec before, Vec first);

  /// Returns D, the scale of errors: the largest deformation of candidates along ν so far, m. Without
  /// candidates it is the largest root mean square of the deformation, m. With time.quantity = "energy" it is
  /// the root of twice the largest elastic energy, in √J (J: joule).
  [[nodiscard]] double scale() const { return scale_; }
  /// Returns the same of the whole displacement, rigid motion included: the scale of errors on springs or
  /// with drag outside of contact, where the rigid motion is not exact.
  [[nodiscard]] double travel() const { return travel_; }
  /// Returns the error e of steps of length τ from the third difference of four displacements at
  /// intervals of τ. `y`: a displacement, for the size of rounding. Collective.
  double error_of(Vec third_difference, Vec y);
  /// Returns whether contact lasts in the last accepted step. Contact ends with the third step in a row that
  /// has no active candidate.
  [[nodiscard]] bool contact() const { return contact_.lasts; }
  /// Returns whether contact with an obstacle lasts in the last accepted step, with pauses of at most two
  /// steps.
  [[nodiscard]] bool contact(std::size_t obstacle) const { return open_[obstacle] < ended; }

  /// A period of contact: the present one or, if no contact lasts, the last one.
  struct Contact {
    bool lasts = false;
    double begin = 0, end = 0; ///< begin of the first, end of the last step with an active candidate, s
    int steps = 0;             ///< number of steps with an active candidate
    double impulse = 0;        ///< N s
    double largest_force = 0;  ///< largest mean of the normal force over two steps, N
  };
  [[nodiscard]] const Contact& last_contact() const { return contact_; }
  [[nodiscard]] const ImpulseRecord& force() const { return force_; }

  /// Rigid part of the motion: coefficients in the basis rigid(), their velocities and their accelerations.
  struct RigidState {
    std::vector<double> position, velocity, acceleration;
  };
  [[nodiscard]] const fem::RigidMotions& rigid() const { return rigid_; }
  [[nodiscard]] const RigidState& rigid_state() const { return rigid_state_; }
  void set_acceleration(std::vector<double> acceleration) {
    rigid_state_.acceleration = std::move(acceleration);
  }
  /// Returns the products of the candidates' normals ν_i with the rigid motions in rigid() (candidates ×
  /// rigid motions).
  [[nodiscard]] const std::vector<double>& rigid_along_normals() const { return normal_; }
  /// Returns R, the largest deformation along ν of an obstacle's candidates since its last contact ended, m.
  [[nodiscard]] double reach(std::size_t obstacle) const { return reach_[obstacle]; }
  /// Returns the largest rate of deformation along ν of an obstacle's candidates since its last contact
  /// ended, m/s.
  [[nodiscard]] double deformation_rate(std::size_t obstacle) const { return deformation_rate_[obstacle]; }
  /// Returns the candidates' gaps after the last accepted step, m.
  [[nodiscard]] const std::vector<double>& gaps() const { return gaps_; }
  /// Returns the least time in which a gap closes at its rate in the last step, s; infinite if no gap closes.
  [[nodiscard]] double closing() const;
  /// Returns the root mean square of a field over the body, weighted by mass. Collective.
  [[nodiscard]] double size(Vec x);
  /// Returns the error of a vibration whose phase is lost since the end of contact, in the unit of scale():
  /// √2 times the root mean square of the deformation in the flight. Infinite until a wave has crossed the
  /// body.
  [[nodiscard]] double without_phases() const;

  /// Returns warnings of effects that the steps did not resolve, at the end of a motion.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  static constexpr int ended = 3; ///< number of steps without active candidates that ends contact
  static constexpr int few_steps = 10;
  struct Mean {
    petsc::Vector w;   ///< mean velocity over a step
    double middle = 0; ///< middle of the step, s
  };
  [[nodiscard]] double norm(Vec x);
  [[nodiscard]] double relative_rounding() const;
  [[nodiscard]] double rounding(Vec y);
  void set_mean(const Frame& frame);
  [[nodiscard]] double error_of(const Frame& frame, bool abrupt);
  /// Returns whether a candidate that is open before and after the step was closed in between, by the
  /// parabola through its last three gaps.
  [[nodiscard]] bool passes(const Frame& frame) const;
  void take_rigid(const Frame& frame);
  void take_deformation(const Frame& frame);
  void take_contact(const Frame& frame);
  /// Returns the contact with the largest impulse among contacts of fewer than few_steps steps. Its number of
  /// steps is 0 if there is no such contact.
  [[nodiscard]] const Contact& coarsest_contact() const {
    const bool coarser =
        contact_.steps > 0 && contact_.steps < few_steps && contact_.impulse > coarsest_.impulse;
    return coarser ? contact_ : coarsest_;
  }
  /// Sets drift_ at the first touch.
  void judge_flight(const Frame& frame);
  /// Returns a warning if the largest force seems to be that of a single wave. Such a force depends on the
  /// mesh and the steps.
  [[nodiscard]] std::optional<Warning> wave_peak_warning() const;

  const step::Stepper& stepper_;
  double tolerance_;
  scene::StepQuantity quantity_;
  double crossing_; ///< time in which a wave crosses the body, s
  fem::RigidMotions rigid_;
  petsc::Vector weights_; ///< lumped masses divided by the body's mass
  double trace_ = 0;      ///< trace of A
  petsc::Vector difference_, work_;
  /// Mean velocities over the step judged and the two before it, the latest first.
  std::array<Mean, 3> means_;
  int known_ = 0;    ///< number of entries of means_ that precede the step judged
  double error_ = 0; ///< error of the step judged; multiplied by of_shortest if the step is a shortest one
  std::optional<contact::ContactPairs::Gaps> psi_;
  std::vector<double> normal_;
  RigidState rigid_state_;
  std::vector<double> gaps_, gaps_before_; ///< gaps after the last and the next-to-last accepted step, m
  std::vector<int> open_;                  ///< number of steps since the last one in contact, by obstacle
  /// Largest deformation along ν, m, and its rate, m/s, by obstacle.
  std::vector<double> reach_, deformation_rate_;
  std::vector<double> deformed_; ///< deformation along ν, after the last accepted step (m)
  double scale_ = 0;
  double travel_ = 0; ///< see travel()
  struct Flight {
    double time = 0, squares = 0, error = 0; ///< duration so far, s; ∫ ‖deformation‖² dt; sum of errors e
  } flight_;
  contact::ActiveSet active_; ///< active set of the last accepted step
  ImpulseRecord force_;
  double force_of_two_ = 0;                 ///< mean normal force over the step judged and the one before, N
  std::array<double, 2> forces_of_two_{};   ///< means over two accepted steps, the latest first, N
  double last_force_ = 0, last_length_ = 0; ///< normal force, N, and length, s, of the last accepted step
  Contact contact_;
  // for warnings():
  double contact_error_ = 0; ///< Σ e of steps in contact that are longer than the shortest
  struct Vibration {
    double time = 0, amplitude = 0, error = 0; ///< time of a touch, s; largest deformation along ν, m,
                                               ///< and error of the vibration before the touch
  } vibration_;
  /// Estimated displacement at the first touch from a rotation that rounding causes, divided by the distance
  /// by which a gap closes while a wave crosses an element.
  double drift_ = 0;
  Contact coarsest_;           ///< contact with the largest impulse among earlier contacts of few steps
  std::vector<double> begins_; ///< times at which contact began, s
  double first_long_ = 0;      ///< begin of the first step in contact that is longer than the shortest, s
};

} // namespace signorini::trajectory
