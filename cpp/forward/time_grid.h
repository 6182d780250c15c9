// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "forward/scheme.h"
#include "scene/scene.h"
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace signorini::forward {

/// The lengths that steps of varying length may have: τ_max 2^−j, j = 0 … levels, of which a whole number of
/// the longest makes the motion. A step of a length begins at a multiple of it, so that all motions end at
/// the same time, to the last bit, and no steps but these lengths' ever occur.
struct Ladder {
  double end;  ///< of the motion, s
  int longest; ///< number of longest steps to it
  int levels;

  /// Of a scene with steps of varying length: the shortest is the longest that is no longer than `floor` (s)
  /// or, if that is longer, than time.shortest.
  Ladder(const scene::Time& time, double floor);
  Ladder(double to, int longest_steps, int halvings) : end(to), longest(longest_steps), levels(halvings) {}

  /// τ_max 2^−level, s.
  [[nodiscard]] double length(int level) const { return end / longest / static_cast<double>(parts(level)); }
  /// 2^level.
  [[nodiscard]] static std::int64_t parts(int level) { return std::int64_t(1) << level; }
};

/// The times of the steps, t_0 = 0, t_k = t_{k−1} + τ_k: N equal ones, or some of a ladder, which are added
/// while the motion is made. Copies refer to the same steps.
class TimeGrid {
public:
  /// N steps of length `tau`.
  TimeGrid(double tau, int steps);
  /// No steps yet.
  explicit TimeGrid(const Ladder& ladder);
  /// Of a scene: all steps, or none yet if their lengths vary; `floor` as of Ladder.
  explicit TimeGrid(const scene::Time& time, double floor = 0);

  /// N, so far.
  [[nodiscard]] int steps() const;
  /// Whether the steps reach the end of the motion.
  [[nodiscard]] bool complete() const;
  /// Whether all steps have the same length, as the scene says.
  [[nodiscard]] bool equal() const { return !steps_->ladder; }
  /// Null for equal steps.
  [[nodiscard]] const Ladder* ladder() const { return equal() ? nullptr : &*steps_->ladder; }

  [[nodiscard]] double time(int k) const;
  /// τ_k, k = 1 … N; for k = 0, where states have no step that led to them, first_length().
  [[nodiscard]] double length(int k) const;
  [[nodiscard]] Scheme scheme(int k) const { return {length(k)}; }
  /// The middle of step k.
  [[nodiscard]] double middle(int k) const;
  /// The last time, of the motion.
  [[nodiscard]] double end() const;
  /// The longest length that a step may have.
  [[nodiscard]] double longest() const;
  /// The length of the first step; if there is none yet, the shortest.
  [[nodiscard]] double first_length() const;
  /// Where a time from 0 to the end is: in step k, at the part of it that is returned too, t = t_{k−1} + part
  /// τ_k; times between two steps count to the former, 0 to the first.
  struct Place {
    int k;
    double part; ///< 0 … 1
  };
  [[nodiscard]] Place place(double t) const;

  /// The number of the ladder's length that step k has.
  [[nodiscard]] int level(int k) const;
  /// The least level that a step after the last one may have: the longest length of which the time reached is
  /// a multiple.
  [[nodiscard]] int least_level() const;
  /// Adds a step.
  void add(int level);
  /// Takes the last step back.
  void remove();
  /// Takes all steps back.
  void clear();

  /// The levels of all steps; none of equal ones.
  [[nodiscard]] std::vector<double> levels() const;
  /// Takes steps of such levels in place of any; false, and unchanged, unless they make up the motion.
  [[nodiscard]] bool take(const std::vector<double>& levels);

private:
  struct Steps {
    double tick; ///< the length of which all others are multiples, s
    int count;   ///< of equal steps
    std::optional<Ladder> ladder;
    std::vector<std::int64_t> ticks; ///< t_k on a ladder
  };
  std::shared_ptr<Steps> steps_;
};

} // namespace signorini::forward
