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

/// The kind of warnings that concern peaks of the force alone.
constexpr const char* peak_of_the_mesh = "peak of the mesh";

/// Local errors of a motion in steps of varying length, from its displacements and forces, and their scales
/// (docs/method.md section 11). A uniform velocity of the body changes no figure.
class StepErrors {
public:
  /// Collective. The references must outlive this object.
  StepErrors(const step::Stepper& stepper, const scene::Scene& scene);

  /// Begins with the state at t_0. Collective.
  void start(Vec y, Vec v);

  /// Error estimates of one step.
  struct Step {
    double error = 0;     ///< e: displacement, m, or √energy; less the part that rounding may have caused
    double bend = 0;      ///< |δ²F̄|/6 of the means of the normal force over two steps, N
    bool touches = false; ///< whether it touches an obstacle that had no contact before
  };
  /// Judges the step after the last accepted one. Collective.
  Step judge(const Frame& frame);
  /// Takes the step that was judged last. Collective.
  void accept(const Frame& frame);

  /// Judges and takes a frame, from frame 0 on, of a motion whose steps were chosen before. Collective.
  void observe(const Frame& frame);

  /// Replaces the mean velocities of the last two steps by those between three displacements, the last of
  /// time `t` (s), `apart` (s) from each other. Longer steps are then judged by means over times of their
  /// own length.
  void coarsen(double t, double apart, Vec last, Vec before, Vec first);

  /// D, the scale of errors: the largest deformation so far, of candidates along ν, m. Without candidates it
  /// is the root mean square; with time.quantity = "energy" the root of the elastic energy.
  [[nodiscard]] double scale() const { return scale_; }
  /// e from the third difference of displacements at equal distances in time, for steps of that length.
  /// Collective.
  double error_of(Vec third_difference, Vec y);
  /// Whether the last accepted step was in contact: no more than two open ones follow a closed one.
  [[nodiscard]] bool contact() const { return contact_.lasts; }
  /// Whether the last accepted step was in contact with one obstacle.
  [[nodiscard]] bool contact(std::size_t obstacle) const { return open_[obstacle] < ended; }

  /// A period of contact: the present one or, without one, the last.
  struct Contact {
    bool lasts = false;
    double begin = 0, end = 0; ///< s; end of the last closed step
    int steps = 0;             ///< number of closed steps
    double impulse = 0;        ///< N s
    double largest_force = 0;  ///< the largest mean over two steps, N
  };
  [[nodiscard]] const Contact& last_contact() const { return contact_; }
  [[nodiscard]] const ImpulseRecord& force() const { return force_; }

  /// The rigid part of the motion: coefficients in rigid(), their velocities and accelerations.
  struct RigidState {
    std::vector<double> position, velocity, acceleration;
  };
  [[nodiscard]] const fem::RigidMotions& rigid() const { return rigid_; }
  [[nodiscard]] const RigidState& rigid_state() const { return rigid_state_; }
  void set_acceleration(std::vector<double> acceleration) {
    rigid_state_.acceleration = std::move(acceleration);
  }
  /// ν_i·(rigid motions) (m × count).
  [[nodiscard]] const std::vector<double>& normal_motions() const { return normal_; }
  /// R: the largest deformation along ν of an obstacle's candidates since its last contact ended, m, and the
  /// largest of its rates, m/s.
  [[nodiscard]] double reach(std::size_t obstacle) const { return reach_[obstacle]; }
  [[nodiscard]] double swing(std::size_t obstacle) const { return swing_[obstacle]; }
  /// Gaps after the last accepted step (m).
  [[nodiscard]] const std::vector<double>& gaps() const { return gaps_; }
  /// The time in which the first gap closes at its present rate, s.
  [[nodiscard]] double closing() const;
  /// Root mean square of a field, weighted by mass.
  [[nodiscard]] double size(Vec x);
  /// Error, as root mean square over time, if the phases of the vibration since contact ended are lost;
  /// infinite before waves have crossed the body.
  [[nodiscard]] double without_phases() const;

  /// Warnings of a motion that the steps did not resolve, for its end.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  static constexpr int ended = 3; ///< open steps after which contact is over
  static constexpr int few_steps = 10;
  struct Mean {
    petsc::Vector w;
    double middle = 0; ///< s
  };
  [[nodiscard]] double norm(Vec x);
  [[nodiscard]] double relative_rounding() const;
  [[nodiscard]] double rounding(Vec y);
  void set_mean(const Frame& frame);
  [[nodiscard]] double error_of(const Frame& frame, bool abrupt);
  /// Whether a candidate that is open before and after the step was closed in between, by the parabola
  /// through three gaps.
  [[nodiscard]] bool passes(const Frame& frame) const;
  void take_rigid(const Frame& frame);
  void take_deformation(const Frame& frame);
  void take_contact(const Frame& frame);
  /// The one of coarsest_ and contact_ with the larger impulse, contact_ only if of few steps.
  [[nodiscard]] const Contact& coarsest_contact() const {
    const bool coarser =
        contact_.steps > 0 && contact_.steps < few_steps && contact_.impulse > coarsest_.impulse;
    return coarser ? contact_ : coarsest_;
  }
  /// Estimates drift_, at the first touch.
  void judge_flight(const Frame& frame);
  /// Warning if the largest force is that of a single wave, which depends on the mesh and the steps.
  [[nodiscard]] std::optional<Warning> peak_warning() const;

  const step::Stepper& stepper_;
  double tolerance_;
  scene::StepQuantity quantity_;
  double crossing_; ///< time in which a wave crosses the body, s
  fem::RigidMotions rigid_;
  petsc::Vector weights_; ///< lumped masses over the mass
  double trace_ = 0;      ///< trace of A
  petsc::Vector difference_, work_;
  std::array<Mean, 3> means_; ///< means over the step judged and the accepted ones before, latest first
  int known_ = 0;             ///< number of accepted steps among them
  double error_ = 0;          ///< error of the step judged, as it counts in a flight
  std::optional<contact::ContactPairs::Gaps> psi_;
  std::vector<double> normal_;
  RigidState rigid_state_;
  std::vector<double> gaps_, gaps_before_; ///< after the last two accepted steps (m)
  std::vector<int> open_;                  ///< steps since the last closed one, by obstacle
  std::vector<double> reach_, swing_;      ///< deformation along ν and its rate, by obstacle
  std::vector<double> deformed_;           ///< deformation along ν, after the last accepted step (m)
  double scale_ = 0;
  struct Flight {
    double time = 0, squares = 0, error = 0; ///< s; ∫ ‖deformation‖² dt; Σ e
  } flight_;
  contact::ActiveSet active_; ///< after the last accepted step
  ImpulseRecord force_;
  double force_of_two_ = 0;                 ///< mean normal force over the step judged and the one before, N
  std::array<double, 2> forces_of_two_{};   ///< means over two accepted steps, the latest first, N
  double last_force_ = 0, last_length_ = 0; ///< normal force and length of the last accepted step
  Contact contact_;
  // for warnings():
  double contact_error_ = 0; ///< Σ e of longer steps in contact
  struct Vibration {
    double time = 0, amplitude = 0, error = 0; ///< time of a touch, s; vibration until then
  } vibration_;
  double drift_ = 0;           ///< rotation by rounding, before the first touch; relative
  Contact coarsest_;           ///< contact of few steps with the largest impulse
  std::vector<double> begins_; ///< begins of contact, s
  double first_long_ = 0;      ///< begin of the first step in contact that is longer than the shortest, s
};

} // namespace signorini::trajectory
