// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "diagnostics/balance.h"
#include "diagnostics/bodies.h"
#include "diagnostics/contact_forces.h"
#include "trajectory/impulse_record.h"
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace signorini::diagnostics {

/// Contact with one obstacle, or with all obstacles, over a motion. Times are not resolved within steps: the
/// force of step k acts from t_{k−1} to t_k. Peaks are largest means over two steps in a row, since forces of
/// single contact-implicit steps alternate (docs/method.md section 2). In plane strain and plane stress
/// forces are per metre of depth, N/m, and impulses N s/m.
struct Touch {
  std::string name;                ///< name of the obstacle
  double start = 0, end = 0;       ///< begin of the first, end of the last step with a contact force, s
  double contact_time = 0;         ///< total length of the steps with a contact force, s
  std::array<double, 3> impulse{}; ///< impulse of the resultant
  double normal_impulse = 0;       ///< impulse of the sum of the moduli of the nodal normal forces
  std::array<double, 3> friction_impulse{}; ///< impulse of the friction forces; zero without friction
  double peak = 0;                          ///< largest modulus of the resultant
  double normal_peak = 0;                   ///< largest sum of the moduli of the nodal forces
  double peak_time = 0;                     ///< time of normal_peak, between its two steps, s
  /// Whether contact began at most a wave's crossing time before the peak, which in a single contact is in
  /// the first quarter; the peak may then be a wave front's, which depends on time step and element size.
  bool peak_at_onset = false;
  double largest_step = 0;     ///< largest sum of the nodal forces' moduli in a single step
  double impulse_duration = 0; ///< time in which normal_impulse grows from 1 to 99 % of its total, s
  double sustained_peak = 0;   ///< largest mean of Σ |nodal force| over a time `sustained_over`, N
  double sustained_over = 0;   ///< time in which a wave crosses four elements in contact, but at least
                               ///< the length of two steps, s
  double least_gap = std::numeric_limits<double>::infinity(); ///< least gap at the end of a step, m
  double least_gap_time = 0;                                  ///< first time of that gap, s

  [[nodiscard]] bool occurred() const { return contact_time > 0; }
};

/// Effect of contact on the motion of the body as a whole. Units of forces and impulses as in Touch.
struct Rebound {
  double start = 0, end = 0; ///< begin of the first, end of the last step with a force, s
  int touches = 1; ///< number of touches; at least two steps in a row without contact separate two touches
  std::array<double, 3> impulse{};          ///< impulse of all obstacles, N s
  std::array<double, 3> friction_impulse{}; ///< part of `impulse` by friction
  double peak = 0;                          ///< largest mean of Σ |nodal force| over two steps, N
  std::array<double, 3> before{},           ///< velocity of the centre of mass at `start`, m/s
      after{};                              ///< velocity of the centre of mass at `end`, m/s
  /// Velocities of an obstacle with mass at these times, m/s; absent if the scene has other obstacles too,
  /// and if springs or rotations are part of its motion.
  std::optional<std::array<double, 3>> obstacle_before{}, obstacle_after{};
  /// Coefficient of restitution −(after·n)/(before·n) of velocities relative to the obstacle, where n is
  /// normal_impulse() with zeros in clamped components.
  /// Defined only if the body moved towards one obstacle, at rest or free, touched no other one, and left it.
  std::optional<double> restitution{};

  /// Returns the impulse without friction.
  [[nodiscard]] std::array<double, 3> normal_impulse() const {
    return {impulse[0] - friction_impulse[0], impulse[1] - friction_impulse[1],
            impulse[2] - friction_impulse[2]};
  }
};

/// Motion of one of several bodies in contact with each other.
struct BodyImpact {
  std::string name;
  double mass = 0;                            ///< kg; in plane strain and plane stress kg/m
  std::array<double, 3> at_start{}, at_end{}; ///< velocity of the centre of mass, m/s
};

/// Motion of the body as a whole before and after contact. Of two bodies in contact with each other it is the
/// one with the group contact.on, unless clamps hold it and not the other one.
struct Impact {
  double mass = 0;                    ///< mass of the body, kg; in plane strain and plane stress kg/m
  std::string body;                   ///< name of the body; empty unless several bodies are in contact
  std::string other = "the obstacle"; ///< what restitution is relative to, if that moves
  std::vector<BodyImpact> bodies;     ///< all bodies, if several are in contact with each other
  std::vector<Touch> obstacles;       ///< contact with each obstacle
  Touch all;                          ///< contact with all obstacles together
  bool ended = false;                 ///< whether no candidate was in contact in the last two steps
  Rebound whole;                      ///< effect of contact, from the first force to the last
  std::vector<Rebound> bounces; ///< effect of each bounce (one touch, or several without flight between)
  std::string no_restitution;   ///< reason why `whole` has no restitution; empty if it has one

  /// Returns whether time `t` (s) is within `crossing` (s) after the begin of a bounce. `crossing`: time in
  /// which a wave crosses the body.
  [[nodiscard]] bool begins(double t, double crossing) const;
};

/// Sources and sinks of a motion's energy, J (in plane strain and plane stress J/m), as sums over its steps.
struct EnergyAccount {
  double kinetic_at_start = 0, elastic_at_start = 0, kinetic_at_end = 0, elastic_at_end = 0;
  double load_work = 0;                    ///< work of the scene's loads
  double other_work = 0;                   ///< work of a control and of moving clamps
  double contact_work = 0;                 ///< work of contact
  double friction_work = 0, belt_work = 0; ///< parts of contact_work: by slip, by the obstacles' surfaces
  double viscous_dissipation = 0;          ///< dissipation by viscosity
  double foundation_at_start = 0, foundation_at_end = 0;   ///< energy of foundations
  double foundation_dissipation = 0, drag_dissipation = 0; ///< dissipation by dashpots and by mass damping
  double relaxation_at_end = 0;                            ///< energy of branches, which start without any
  double relaxation_dissipation = 0;                       ///< dissipation by relaxation
  double rigid_at_start = 0, rigid_at_end = 0; ///< energy of obstacles with mass, and of their springs
  double rigid_dissipation = 0;                ///< dissipation by their dashpots
  double residual = 0;                         ///< residual of the energy law

  /// Returns the work of contact without friction: that of a scheme, or of obstacles that move.
  [[nodiscard]] double normal_work() const { return contact_work - friction_work - belt_work; }
};

/// Sums up energies and contact of a motion frame by frame.
class ImpactSummary {
public:
  /// Prepares the summary. `bodies`: observed before this object; null unless parts of the body are in
  /// contact. Collective. The references must outlive this object.
  ImpactSummary(const step::Stepper& stepper, const scene::Scene& scene, const Bodies* bodies = nullptr);

  /// Takes the next frame with its balance and contact forces; frames are passed in order, from frame 0 on.
  /// Collective.
  void observe(const trajectory::Frame& frame, const StepBalance& balance, const ObstacleForces& forces);

  /// Returns whether a bounce is over: the body has left the obstacle for the time in which a wave crosses it
  /// and returns, and its restitution is known or cannot be.
  [[nodiscard]] bool bounced() const;

  [[nodiscard]] const EnergyAccount& energy() const { return energy_; }
  /// Returns the effect of contact so far; nothing in a scene without contact.
  [[nodiscard]] std::optional<Impact> impact() const;

private:
  /// Contact with one obstacle, or with all, in the last step: the forces, for means over two steps, and data
  /// on pauses of contact.
  struct Last {
    std::array<double, 3> force{};
    double normal_force = 0;
    int open = 0;     ///< number of steps in a row without a force
    double begun = 0; ///< begin of the latest contact that follows at least two steps without a force, s
  };
  /// Adds one step to the contact with an obstacle, or with all.
  void take(const trajectory::Frame& frame, const ObstacleForce& now, Touch& touch, Last& last) const;
  using Velocity = std::optional<std::array<double, 3>>;
  /// Adds one step with a force to the current touch. `before`, `after`: the body's momentum before and after
  /// the step, kg m/s; `obstacle_before`: velocity of an obstacle with mass before the step.
  void rebound(const trajectory::Frame& frame, const ObstacleForce& now, const std::array<double, 3>& before,
               const std::array<double, 3>& after, const Velocity& obstacle_before);
  /// Returns the reason why no bounce of the motion has a coefficient of restitution; empty if there is
  /// no such reason.
  [[nodiscard]] std::string no_restitution_reason() const;
  /// Returns the bounces. Touches between which the body does not fly are joined into one bounce.
  [[nodiscard]] std::vector<Rebound> bounces() const;
  /// Returns whether two successive rebounds belong to one bounce, because the body does not fly in the pause
  /// between them. They do if the pause is at most half as long as the shorter rebound, or at most as long as
  /// a wave takes to cross the body and return. If `restitution_possible` (no_restitution_reason() is empty),
  /// they also do if the first rebound does not turn the body away from the obstacle.
  [[nodiscard]] bool one_bounce(const Rebound& first, const Rebound& second, bool restitution_possible) const;
  /// Returns the coefficient of restitution −(after·n)/(before·n) of velocities relative to the obstacle,
  /// where n is the impulse of `rebound` with zeros in clamped components. Returns nothing unless the body
  /// moves towards the obstacle before the rebound, and away from it afterwards.
  [[nodiscard]] std::optional<double> restitution(const Rebound& rebound) const;
  /// Returns the scalar product of a velocity, relative to that of an obstacle with mass, and an impulse over
  /// the components without clamps.
  [[nodiscard]] double along(const std::array<double, 3>& velocity, const std::array<double, 3>& impulse,
                             const Velocity& obstacle = {}) const;

  /// The two bodies of the only contact of a scene.
  struct Two {
    int body, other; ///< the body whose motion is summarised, and the one that it hits
    bool fixed;      ///< whether a clamp holds the other body
    double side;     ///< factor of forces on contact.on in forces on the body, ±1
  };
  /// Returns the two bodies of the contact; nothing if a group is on several bodies. Collective.
  [[nodiscard]] static std::optional<Two> two_bodies(const step::Stepper& stepper,
                                                     const scene::Contact& contact, const Bodies& bodies);
  /// Returns the momentum of the body, kg m/s, and the velocity of the obstacle or of the other body, m/s.
  [[nodiscard]] std::array<double, 3> body_momentum(const StepBalance& balance) const;
  [[nodiscard]] Velocity velocity_of_other(const trajectory::Frame& frame) const;

  const step::Stepper& stepper_;
  const Bodies* bodies_;       ///< null unless parts of the body are in contact
  std::optional<Two> two_;     ///< absent unless the scene has one contact, between two bodies
  std::array<bool, 3> free_{}; ///< components without clamps
  bool moving_;
  const contact::RigidMotion* flies_ = nullptr; ///< the only obstacle, if it has mass and flies freely
  Velocity obstacle_velocity_;                  ///< of that obstacle, m/s
  double now_ = 0;                              ///< end of the last step, s
  double crossing_;                             ///< time in which a wave crosses the body, s
  EnergyAccount energy_;
  Impact impact_;
  std::vector<Last> last_; ///< entries for each obstacle, then for all together
  /// Records of the sums of the nodal forces' moduli, for each obstacle, then for all together.
  std::vector<trajectory::ImpulseRecord> records_;
  std::vector<Rebound> touches_;
  std::array<double, 3> momentum_{};                     ///< body's momentum, kg m/s
  std::array<double, 3> impulse_{}, friction_impulse_{}; ///< of contact, of friction before the last touch
  int open_steps_ = 0; ///< number of steps in a row without a candidate in contact
  bool parted_ = true; ///< whether the pause is long enough that the next force begins a touch
};

} // namespace signorini::diagnostics
