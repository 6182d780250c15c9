// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include "step/scheme.h"
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace signorini::step {

/// The lengths that steps of varying length may have: τ_max 2^−j, j = 0 … levels. The motion is a whole
/// number of the longest steps. A step of a length begins at a multiple of it, so that all motions end at
/// the same time, to the last bit, and no other lengths ever occur.
struct StepLengths {
  double end;  ///< end of the motion, s
  int longest; ///< number of longest steps in the motion
  int levels;

  /// Makes the lengths of a scene with varying steps. The shortest is the longest that is no longer than
  /// `floor` (s); with time.shortest it is no shorter than that.
  StepLengths(const scene::Time& time, double floor);
  StepLengths(double to, int longest_steps, int halvings)
      : end(to), longest(longest_steps), levels(halvings) {}

  /// τ_max 2^−level, s.
  [[nodiscard]] double length(int level) const { return end / longest / static_cast<double>(parts(level)); }
  /// The length of the longest, the shortest steps, s.
  [[nodiscard]] double longest_step() const { return length(0); }
  [[nodiscard]] double shortest_step() const { return length(levels); }
  /// The level of a step of these lengths.
  [[nodiscard]] int level(double tau) const;
  /// 2^level.
  [[nodiscard]] static std::int64_t parts(int level) { return std::int64_t(1) << level; }
  /// The end in units of the shortest length.
  [[nodiscard]] std::int64_t ticks() const { return longest * parts(levels); }
};

/// Step k of a motion, from t_{k−1} to t_k. k = 0 is the initial state, to which no step leads: t_0 alone,
/// with the length of a first step.
struct TimeStep {
  int k = 0;
  double begin = 0, end = 0; ///< t_{k−1} and t_k, s
  double tau = 0;            ///< τ_k, s; end − begin but for rounding

  [[nodiscard]] Scheme scheme() const { return {tau}; }
};

/// The times of a motion's steps, t_0 = 0, t_k = t_{k−1} + τ_k: N equal ones, or some of a set of lengths.
/// Never changes; copies are cheap.
class TimeGrid {
public:
  /// N steps of length `tau`.
  TimeGrid(double tau, int steps);
  /// No steps: their lengths are still to be chosen from a set of lengths.
  explicit TimeGrid(const StepLengths& step_lengths);
  /// The grid of a scene: all steps, or none where their lengths vary.
  explicit TimeGrid(const scene::Time& time);
  /// Makes steps of a set of lengths from their levels, as levels() returns them; nothing unless they make up
  /// the motion.
  [[nodiscard]] static std::optional<TimeGrid> of_levels(const StepLengths& step_lengths,
                                                         const std::vector<double>& levels);

  /// The first steps alone, N or fewer.
  [[nodiscard]] TimeGrid first(int steps) const;

  /// N; the number of steps made, if the motion was interrupted while its steps were chosen.
  [[nodiscard]] int steps() const;
  /// Whether the steps reach the end of the motion.
  [[nodiscard]] bool complete() const;
  /// Whether all steps have the same length, as the scene says.
  [[nodiscard]] bool equal() const { return !steps_->step_lengths; }

  [[nodiscard]] double time(int k) const;
  /// τ_k, k = 1 … N; for k = 0, where states have no step that led to them, τ_1.
  [[nodiscard]] double length(int k) const;
  [[nodiscard]] TimeStep step(int k) const { return {k, time(k > 0 ? k - 1 : 0), time(k), length(k)}; }
  [[nodiscard]] Scheme scheme(int k) const { return {length(k)}; }
  /// The middle of step k.
  [[nodiscard]] double middle(int k) const;
  /// The last time, of the motion.
  [[nodiscard]] double end() const;
  /// Position of a time from 0 to the end in the grid: step k and the part of it, t = t_{k−1} + part τ_k. A
  /// time between two steps belongs to the former, 0 to the first.
  struct Place {
    int k;
    double part; ///< 0 … 1
  };
  [[nodiscard]] Place place(double t) const;

  /// The levels of all steps on their lengths; none of equal ones.
  [[nodiscard]] std::vector<double> levels() const;

private:
  friend class TimeGridBuilder;
  struct Steps {
    double tick; ///< the length of which all others are multiples, s
    int count;   ///< number of equal steps
    std::optional<StepLengths> step_lengths;
    std::vector<std::int64_t> ticks; ///< t_k in units of the shortest length
  };
  explicit TimeGrid(Steps steps) : steps_(std::make_shared<const Steps>(std::move(steps))) {}

  std::shared_ptr<const Steps> steps_;
};

/// Makes a TimeGrid of such lengths step by step, while a motion is made.
class TimeGridBuilder {
public:
  explicit TimeGridBuilder(const StepLengths& step_lengths) : step_lengths_(step_lengths), ticks_{0} {}

  [[nodiscard]] const StepLengths& step_lengths() const { return step_lengths_; }
  [[nodiscard]] int steps() const { return static_cast<int>(ticks_.size()) - 1; }
  /// Whether the steps reach the end of the motion.
  [[nodiscard]] bool complete() const { return ticks_.back() == step_lengths_.ticks(); }
  /// The least level that a step after the last one may have: the time reached is a multiple of its length,
  /// and of no longer one.
  [[nodiscard]] int least_level() const;
  /// Adds a step, and returns it.
  TimeStep add(int level);
  /// Removes the last step.
  void remove() { ticks_.pop_back(); }
  void clear() { ticks_.resize(1); }
  /// The steps so far.
  [[nodiscard]] TimeGrid grid() const;

private:
  StepLengths step_lengths_;
  std::vector<std::int64_t> ticks_; ///< t_k in units of the shortest length
};

} // namespace signorini::step
