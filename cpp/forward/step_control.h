// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "forward/integrate.h"
#include "forward/time_dependence.h"
#include <array>
#include <vector>

namespace signorini::forward {

/// Chooses the lengths of steps from a ladder while a motion is made (docs/method.md section 11): judges each
/// step by an estimate of the error that it adds, has it made again where that is too large, and proposes the
/// length of the next one.
///
/// The error of a step of the trapezoidal rule is τ³/12 of the third derivative, here from the mean
/// velocities w = (y_k − y_{k−1})/τ_k of the last three steps: these, unlike velocities and contact forces of
/// single steps, do not alternate in contact. With δ the distance of w_k from the straight line through the
/// two before it, in time at the middles m of the steps,
///     e = τ_k/12 δ min(1, 2 τ_k² / ((m_k − m_{k−1})(m_k − m_{k−2})))
/// where the minimum holds for a motion that is smooth, and 1 stands in its place in steps in which contact
/// changes or that are made again: all of δ has then come about in the step itself.
/// Displacement: e in the norm of the mass, relative to the largest displacement; a free body drifts besides,
/// for the time that is left, with the error of its mean velocity: 1/12 of the distance of the newest one
/// from the parabola through the three before it. Contact force: the same e of the resultant's mean over two
/// steps, an impulse, relative to the whole one, or to the momentum √(2 m E) if that is larger. Energy:
/// √(e·Ae), relative to √(2 E), E the largest kinetic energy. How large all these are, a first motion of
/// longest steps tells.
///
/// A step in which contact begins or ends is no longer than the tolerance times the longest phase of contact
/// so far, so that its duration is known as well.
///
/// What the scene prescribes over time is resolved in any case (TimeDependence).
///
/// A length that has not occurred yet costs a factorisation, as much as some steps. So a step that is too
/// long gives way to one at hand if that is not much too short, longer steps are taken once shorter ones have
/// cost as much, and a touch is neared by few lengths.
class StepControl {
public:
  /// Collective. The references must outlive this object.
  StepControl(const Stepper& stepper, const scene::Scene& scene);

  /// Begins with the state at t_0, and a level for the first two steps, of which the second one is judged.
  /// Collective.
  void start(Vec y, Vec v, int level);
  /// Takes the sizes, by which errors are judged, from a step of a coarse motion. Collective.
  void size_up(const Frame& frame);
  /// The level of the next step.
  [[nodiscard]] int level() const { return level_; }
  /// Whether step k is good, the last of the grid; if not, level() is that by which to make it again; if it
  /// is, that of the next one. Collective, the same on every rank.
  [[nodiscard]] bool accepts(const Frame& frame, const contact::ContactSets& before);

  /// Steps that were made again, so far.
  [[nodiscard]] int rejected() const { return rejected_; }

private:
  /// Mean velocity of a step, the resultant of its contact forces, and the middle of the step.
  struct Mean {
    petsc::Vector w;
    std::array<double, 3> rigid{}, force{}; ///< momentum of w over the mass (m/s); N
    double middle = 0, end = 0, tau = 0;    ///< s
  };
  /// The local error, relative.
  double error(const Frame& frame, bool abrupt);
  /// By e = factor · difference_, and for the drift the part of it that counts, the minimum above.
  double displacement_error(const Frame& frame, double factor, double part) const;
  [[nodiscard]] double force_error(double tau, double part) const;
  double energy_error(double factor);
  void set_means(const Frame& frame);
  void take_sizes(const Frame& frame);
  /// The level of the step that follows a good one.
  [[nodiscard]] int next_level(const Frame& frame, double found);
  /// A level from `allowed` on, of which lengths are at hand if one is near enough.
  [[nodiscard]] int at_hand(int allowed, int near) const;
  /// The level from `level` on at which a step from time `t` resolves what the scene prescribes.
  [[nodiscard]] int resolving(int level, double t) const;
  /// The time until a candidate touches, by the gaps' velocities; the whole time if none nears.
  [[nodiscard]] double until_touch(const Frame& frame);
  /// Root of the mean square, by mass.
  [[nodiscard]] double size(Vec x) const;

  const Stepper& stepper_;
  scene::StepQuantity quantity_;
  double tolerance_;
  Ladder ladder_;
  TimeDependence prescribed_;
  petsc::Vector weights_; ///< lumped masses
  double mass_ = 0;
  std::array<petsc::Vector, 3> rigid_; ///< M e_c
  bool free_ = true;
  std::array<Mean, 4> means_; ///< of the step judged, and the good ones before it, the latest first
  static constexpr int most_known = 3;
  int known_ = 0; ///< good ones among them
  petsc::Vector difference_, work_, start_;
  /// Of the motion as far as it is known: largest displacement (root mean square, m), largest kinetic energy,
  /// largest impulse of contact so far and in a coarse motion.
  double displacement_ = 0, energy_ = 0, impulse_ = 0, coarse_impulse_ = 0;
  std::vector<double> gaps_; ///< after the last good step (m)
  /// Contact from a touch to the release, including pauses that are short beside it.
  struct Phase {
    int steps = 0;
    double begun = 0, last = 0, longest = 0; ///< s; the longest duration so far
    void observe(double from, double to, bool touches);
  };
  Phase phase_;
  std::vector<bool> used_; ///< by level; whatever memory holds, so that the motion does not depend on that
  int touching_level_ = 0; ///< of steps that may touch, as far as is known
  int held_level_ = 0;     ///< of steps until a release is over that a longer one has missed
  double held_until_ = 0;  ///< s
  double lost_ = 0;        ///< steps that longer ones would have saved, had they been at hand
  int level_ = 0, rejected_ = 0;
  bool again_ = false;
};

} // namespace signorini::forward
