// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include "step/scheme.h"
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace signorini::step {

/// Lengths that automatic steps may have: τ_max 2^−j at the levels j = 0 … levels. The motion is a whole
/// number of steps of length τ_max. A step begins at a multiple of its own length, so that steps of any
/// lengths fill the motion exactly and all motions end at the same time, to the last bit.
struct StepLengths {
  double end;  ///< end of the motion, s
  int longest; ///< number of steps of length τ_max in the motion
  int levels;  ///< level of the shortest steps

  /// Creates the lengths for a scene with automatic steps. Levels end with the first length of at most
  /// `floor` (s), with level 40, or before a length falls below time.shortest.
  StepLengths(const scene::Time& time, double floor);
  /// Creates the lengths to / longest_steps · 2^−j, j = 0 … halvings, of a motion that ends at `to` (s).
  StepLengths(double to, int longest_steps, int halvings)
      : end(to), longest(longest_steps), levels(halvings) {}

  /// Returns the step length of a level, τ_max 2^−level, s.
  [[nodiscard]] double length(int level) const { return end / longest / static_cast<double>(parts(level)); }
  /// Returns the longest step length τ_max, s.
  [[nodiscard]] double longest_step() const { return length(0); }
  /// Returns the shortest step length, s.
  [[nodiscard]] double shortest_step() const { return length(levels); }
  /// Returns the level of the step length `tau` (s).
  [[nodiscard]] int level(double tau) const;
  /// Returns 2^level, the number of steps of a level in a longest step.
  [[nodiscard]] static std::int64_t parts(int level) { return std::int64_t(1) << level; }
  /// Returns the end of the motion in units of the shortest step length.
  [[nodiscard]] std::int64_t ticks() const { return longest * parts(levels); }
};

/// Returns the lengths that automatic steps may have; none if time.step is given. At the usual tolerance
/// (1e-2) the shortest is at most half of `wave_time` (s). It scales with the root of the tolerance, since
/// the error of a contact that begins within a step falls as the square of the step's length. The longest is
/// at most twice the time of each branch that relaxes and that the shortest steps resolve: in longer steps
/// its internal displacement would alternate in sign.
std::optional<StepLengths> step_lengths(const scene::Scene& scene, double wave_time);

/// Step k of a motion, from t_{k−1} to t_k. k = 0 stands for the initial state, to which no step leads: its
/// begin and end are t_0, its tau is the length of a first step.
struct TimeStep {
  int k = 0;
  double begin = 0, end = 0; ///< t_{k−1} and t_k, s
  double tau = 0;            ///< τ_k, s; for k > 0 end − begin up to rounding

  [[nodiscard]] Scheme scheme() const { return {tau}; }
};

/// Times of a motion's steps, t_0 = 0, t_k = t_{k−1} + τ_k, with N equal steps or with automatic steps of
/// StepLengths. Immutable; copies are cheap.
class TimeGrid {
public:
  /// Creates a grid of N = `steps` equal steps of length `tau` (s).
  TimeGrid(double tau, int steps);
  /// Creates a grid without steps, whose lengths are still to be chosen from `step_lengths`.
  explicit TimeGrid(const StepLengths& step_lengths);
  /// Creates the grid of a scene: all steps if they are equal, none yet if they are automatic.
  explicit TimeGrid(const scene::Time& time);
  /// Creates a grid of automatic steps from their levels, as levels() returns them. Returns nothing if these
  /// steps do not make up the motion.
  [[nodiscard]] static std::optional<TimeGrid> of_levels(const StepLengths& step_lengths,
                                                         const std::vector<double>& levels);

  /// Returns the grid of the first `steps` steps alone, at most N.
  [[nodiscard]] TimeGrid first(int steps) const;

  /// Returns the number of steps N; if a motion was interrupted while its steps were chosen, the number made.
  [[nodiscard]] int steps() const;
  /// Whether the steps reach the end of the motion.
  [[nodiscard]] bool complete() const;
  /// Returns whether the grid has equal steps rather than automatic ones.
  [[nodiscard]] bool equal() const { return !steps_->step_lengths; }

  /// Returns t_k, s.
  [[nodiscard]] double time(int k) const;
  /// Returns the step length τ_k, s, k = 1 … N. For k = 0, the initial state, it is τ_1.
  [[nodiscard]] double length(int k) const;
  [[nodiscard]] TimeStep step(int k) const { return {k, time(k > 0 ? k - 1 : 0), time(k), length(k)}; }
  [[nodiscard]] Scheme scheme(int k) const { return {length(k)}; }
  /// Returns the middle of step k, s.
  [[nodiscard]] double middle(int k) const;
  /// Returns the last time of the motion, s.
  [[nodiscard]] double end() const;
  /// Position of a time t in the grid: t = t_{k−1} + part τ_k. A time at which two steps meet belongs to the
  /// earlier step, t = 0 to the first step.
  struct Place {
    int k;
    double part; ///< fraction of step k, 0 … 1
  };
  /// Returns the position of time `t` (s), from 0 to end().
  [[nodiscard]] Place place(double t) const;

  /// Returns the levels of all steps in StepLengths, in the order of time; empty for equal steps.
  [[nodiscard]] std::vector<double> levels() const;

private:
  friend class TimeGridBuilder;
  struct Steps {
    double tick; ///< length of which all step lengths are multiples, s
    int count;   ///< number of equal steps; 0 for automatic steps
    std::optional<StepLengths> step_lengths;
    std::vector<std::int64_t> ticks; ///< t_k in units of the shortest length
  };
  explicit TimeGrid(Steps steps) : steps_(std::make_shared<const Steps>(std::move(steps))) {}

  std::shared_ptr<const Steps> steps_;
};

/// Builds a TimeGrid of automatic steps, step by step, while a motion is integrated.
class TimeGridBuilder {
public:
  explicit TimeGridBuilder(const StepLengths& step_lengths) : step_lengths_(step_lengths), ticks_{0} {}

  [[nodiscard]] const StepLengths& step_lengths() const { return step_lengths_; }
  [[nodiscard]] int steps() const { return static_cast<int>(ticks_.size()) - 1; }
  /// Whether the steps reach the end of the motion.
  [[nodiscard]] bool complete() const { return ticks_.back() == step_lengths_.ticks(); }
  /// Returns the least level that the next step may have, so that it begins at a multiple of its length.
  [[nodiscard]] int least_level() const;
  /// Appends a step of this level and returns it.
  TimeStep add(int level);
  /// Removes the last step.
  void remove() { ticks_.pop_back(); }
  /// Removes all steps.
  void clear() { ticks_.resize(1); }
  /// Returns the grid of the steps so far.
  [[nodiscard]] TimeGrid grid() const;

private:
  StepLengths step_lengths_;
  std::vector<std::int64_t> ticks_; ///< t_k in units of the shortest length
};

} // namespace signorini::step
