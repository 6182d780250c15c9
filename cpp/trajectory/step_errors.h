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

/// Local errors of a motion in steps of varying length, by its own displacements and forces, and what they
/// are judged by (docs/method.md section 11). No figure changes where the body moves by a uniform velocity.
class StepErrors {
public:
  /// Collective. The references must outlive this object.
  StepErrors(const step::Stepper& stepper, const scene::Scene& scene);

  /// Begins with the state at t_0. Collective.
  void start(Vec y, Vec v);

  /// What a step leaves.
  struct Step {
    double error = 0;     ///< e: displacement, m, or √energy; what rounding may have made of it is taken off
    double bend = 0;      ///< |δ²F̄|/6 of the means of the normal force over two steps, N
    bool touches = false; ///< an obstacle that no candidate was in contact with
  };
  /// Judges the step after the last accepted one. Collective.
  Step judge(const Frame& frame);
  /// Takes the step that was judged last. Collective.
  void accept(const Frame& frame);

  /// Judges and takes a frame, from frame 0 on, of a motion whose steps were chosen before. Collective.
  void observe(const Frame& frame);

  /// Replaces the mean velocities of the last two steps by those between three displacements, the last of
  /// time `t` (s), `apart` (s) from each other: longer steps are then judged by what steps of their length
  /// were.
  void coarsen(double t, double apart, Vec last, Vec before, Vec first);

  /// D, by which errors are judged: the largest deformation so far, of candidates along ν in m; without any,
  /// root of the mean square; with time.quantity = "energy" of the elastic energy.
  [[nodiscard]] double scale() const { return scale_; }
  /// e by the third difference of displacements at equal times: of steps as long as these are apart.
  /// Collective.
  double error_of(Vec third_difference, Vec y);
  /// Whether the last accepted step was in contact: no more than two open ones follow a closed one.
  [[nodiscard]] bool contact() const { return contact_.lasts; }
  /// The same of one obstacle.
  [[nodiscard]] bool contact(std::size_t obstacle) const { return open_[obstacle] < ended; }

  /// Of the contact that lasts, or of the last one.
  struct Contact {
    bool lasts = false;
    double begin = 0, end = 0; ///< s; end: of the last closed step
    int steps = 0;             ///< closed ones
    double impulse = 0;        ///< N s
    double largest_force = 0;  ///< of the means of two steps, N
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
  /// Root of the mean square, by mass.
  [[nodiscard]] double size(Vec x);
  /// What is left of the error, in the root of the mean square over time, if the phases of the vibration
  /// since contact ended are lost; infinite before waves have crossed the body.
  [[nodiscard]] double without_phases() const;

  /// Where the steps were too long for what the motion turned out to be. At the end of a motion.
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
  /// Whether a candidate that is open before the step and after it was not within it, by the parabola through
  /// three gaps.
  [[nodiscard]] bool passes(const Frame& frame) const;
  void take_rigid(const Frame& frame);
  void take_deformation(const Frame& frame);
  void take_contact(const Frame& frame);
  /// Of coarsest_ and the contact that lasts.
  [[nodiscard]] const Contact& coarsest_contact() const {
    const bool coarser =
        contact_.steps > 0 && contact_.steps < few_steps && contact_.impulse > coarsest_.impulse;
    return coarser ? contact_ : coarsest_;
  }
  /// Before the first touch.
  void judge_flight(const Frame& frame);
  /// Where the largest force is that of a single wave, which the mesh and the steps decide.
  [[nodiscard]] std::optional<Warning> peak_warning() const;

  const step::Stepper& stepper_;
  double tolerance_;
  scene::StepQuantity quantity_;
  double crossing_; ///< of a wave, s
  fem::RigidMotions rigid_;
  petsc::Vector weights_; ///< lumped masses over the mass
  double trace_ = 0;      ///< of A
  petsc::Vector difference_, work_;
  std::array<Mean, 3> means_; ///< of the step judged, and the accepted ones before it, the latest first
  int known_ = 0;             ///< accepted ones among them
  double error_ = 0;          ///< of the step judged, as it counts in a flight
  std::optional<contact::ContactPairs::Gaps> psi_;
  std::vector<double> normal_;
  RigidState rigid_state_;
  std::vector<double> gaps_, gaps_before_; ///< after the last two accepted steps (m)
  std::vector<int> open_;                  ///< steps since the last closed one, by obstacle
  std::vector<double> reach_, swing_;      ///< by obstacle
  std::vector<double> deformed_;           ///< along ν, after the last accepted step (m)
  double scale_ = 0;
  struct Flight {
    double time = 0, squares = 0, error = 0; ///< s; ∫ ‖deformation‖² dt; Σ e
  } flight_;
  contact::ActiveSet active_; ///< after the last accepted step
  ImpulseRecord force_;
  double force_of_two_ = 0;                 ///< mean normal force over two steps, of the one judged
  std::array<double, 2> forces_of_two_{};   ///< of the accepted ones, the latest first
  double last_force_ = 0, last_length_ = 0; ///< of the last accepted step
  Contact contact_;
  /// For the warnings.
  double contact_error_ = 0; ///< Σ e
  struct Vibration {
    double time = 0, amplitude = 0, error = 0; ///< of a touch; relative
  } vibration_;
  double drift_ = 0;           ///< by rounding, before the first touch; relative
  Contact coarsest_;           ///< of few steps, that of the largest impulse
  std::vector<double> begins_; ///< of contact, s
  double first_long_ = 0;      ///< begin of the first step in contact that is longer than the shortest, s
};

} // namespace signorini::trajectory
