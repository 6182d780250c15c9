// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "diagnostics/balance.h"
#include "diagnostics/contact_forces.h"
#include "trajectory/impulse_record.h"
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace signorini::diagnostics {

/// Contact with one obstacle, or with all of them, over a motion. In 2D forces are N/m, impulses N s/m. Times
/// are those of steps: the force of step k acts from t_{k−1} to t_k. Peaks are those of the mean of two steps
/// in a row, since the forces of single contact-implicit steps alternate (docs/method.md section 2).
struct Touch {
  std::string name;                ///< name of the obstacle
  double start = 0, end = 0;       ///< begin of the first step with a contact force, end of the last one, s
  double contact_time = 0;         ///< duration of all steps with a contact force, s
  std::array<double, 3> impulse{}; ///< impulse of the resultant
  double normal_impulse = 0;       ///< impulse of the sum of the moduli of the nodal forces
  double peak = 0;                 ///< largest modulus of the resultant
  double normal_peak = 0;          ///< largest sum of the moduli of the nodal forces
  double peak_time = 0;            ///< time of that sum, between its two steps, s
  bool peak_at_onset = false;      ///< whether a wave has not crossed the body since contact began: the peak
                                   ///< is then that of the first hit, and mostly depends on step and size
  double largest_step = 0;         ///< largest sum of the moduli in a single step
  double impulse_duration = 0;     ///< time from 1 to 99 % of the normal impulse, s
  double sustained_peak = 0;       ///< largest mean of the sum of the moduli over `sustained_over`, N
  double sustained_over = 0;       ///< time in which a wave crosses four elements in contact, or two steps, s
  double least_gap = std::numeric_limits<double>::infinity(); ///< least gap at the end of a step, m
  double least_gap_time = 0;                                  ///< first time of that gap, s

  [[nodiscard]] bool occurred() const { return contact_time > 0; }
};

/// Effect of contact on the motion of the body as a whole.
struct Rebound {
  double start = 0, end = 0;       ///< begin of the first and end of the last step with a force, s
  int touches = 1;                 ///< between two, no candidate is in contact for two steps or more
  std::array<double, 3> impulse{}; ///< impulse of all obstacles, N s, in 2D N s/m
  double peak = 0;                 ///< Touch::normal_peak of these steps
  std::array<double, 3> before{},  ///< velocity of the centre of mass at the start, m/s
      after{};                     ///< velocity at the end, m/s
  /// Restitution −(after·n)/(before·n) along n, the part of the impulse in components without clamps. Only of
  /// a body that moved towards one obstacle at rest, touched no other, and left it.
  std::optional<double> restitution{};
};

/// The motion of the body as a whole before and after contact.
struct Impact {
  double mass = 0; ///< kg, in 2D kg/m
  std::vector<Touch> obstacles;
  Touch all;
  bool ended = false;           ///< whether no candidate was in contact in the last two steps
  Rebound whole;                ///< effect from the first contact to the last
  std::vector<Rebound> bounces; ///< one by one: touches with longer pauses between them than within
  std::string no_restitution;   ///< why `whole` has no restitution; empty if it has one

  /// Whether `t` is within `crossing`, the time (s) that a wave takes across the body, after a bounce began.
  [[nodiscard]] bool begins(double t, double crossing) const;
};

/// Sources and sinks of the energy of a motion, J, in 2D J/m: the sums over its steps.
struct EnergyAccount {
  double kinetic_at_start = 0, elastic_at_start = 0, kinetic_at_end = 0, elastic_at_end = 0;
  double load_work = 0;           ///< work of the scene's loads
  double other_work = 0;          ///< work of a control and of clamps that move
  double contact_work = 0;        ///< work of contact
  double viscous_dissipation = 0; ///< dissipation by viscosity
  double residual = 0;            ///< residual of the energy law
};

/// Sums up energies and contact of a motion frame by frame.
class ImpactSummary {
public:
  /// Collective. The references must outlive this object.
  ImpactSummary(const step::Stepper& stepper, const scene::Scene& scene);

  /// Takes the frame after the last one, from frame 0 on, its balance and its contact forces. Not collective.
  void observe(const trajectory::Frame& frame, const StepBalance& balance, const ObstacleForces& forces);

  [[nodiscard]] const EnergyAccount& energy() const { return energy_; }
  /// Effect of contact; absent in a scene without contact.
  [[nodiscard]] std::optional<Impact> impact() const;

private:
  /// State of an obstacle, or of all, after the last step, for means of two steps.
  struct Last {
    std::array<double, 3> force{};
    double normal_force = 0;
    int open = 0;     ///< steps in a row without a force, before the first one too
    double begun = 0; ///< time at which contact last began after that, s
  };
  void take(const trajectory::Frame& frame, const ObstacleForce& now, Touch& touch, Last& last) const;
  /// Adds one step to the current bounce: the body's momentum before and after it, kg m/s.
  void rebound(const trajectory::Frame& frame, const ObstacleForce& now, const std::array<double, 3>& before,
               const std::array<double, 3>& after);
  /// Reason why no coefficient of restitution is defined; empty if one may be.
  [[nodiscard]] std::string unfit() const;
  /// Groups touches into bounces: a flutter is one bounce.
  [[nodiscard]] std::vector<Rebound> bounces() const;
  /// Whether two rebounds are one bounce, since the pause between them is no flight. It is short beside both,
  /// or shorter than the shortest bounce, in which a wave crosses the body and returns. Or the body, if `fit`
  /// for a restitution, has not turned.
  [[nodiscard]] bool one_bounce(const Rebound& first, const Rebound& second, bool fit) const;
  /// Restitution −(after·n)/(before·n), if the body came nearer and left.
  [[nodiscard]] std::optional<double> restitution(const Rebound& rebound) const;
  /// The product of a velocity and an impulse in components without clamps.
  [[nodiscard]] double along(const std::array<double, 3>& velocity,
                             const std::array<double, 3>& impulse) const;

  const step::Stepper& stepper_;
  std::array<bool, 3> free_{}; ///< components without clamps
  bool moving_;
  double crossing_; ///< crossing time of a wave, s
  EnergyAccount energy_;
  Impact impact_;
  std::vector<Last> last_;                         ///< states of each obstacle, then of all
  std::vector<trajectory::ImpulseRecord> records_; ///< sums of the moduli, of each obstacle, then of all
  std::vector<Rebound> touches_;
  std::array<double, 3> momentum_{}, impulse_{}; ///< body's momentum; contact impulse before the last touch
  int open_steps_ = 0;                           ///< steps in a row without a candidate in contact
  bool parted_ = true; ///< whether so many were open that the next force begins a touch
};

} // namespace signorini::diagnostics
