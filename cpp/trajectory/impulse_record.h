// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

namespace signorini::trajectory {

/// Window over which a peak force is a mean, in units of the time that a wave takes through an element in
/// contact.
constexpr double sustained = 4;

/// A force over time, constant in each step, and figures of it that converge with the steps, which its values
/// in single steps do not (docs/method.md section 8).
class ImpulseRecord {
public:
  /// Adds a step that ends at `t` (s) with a force (N).
  void add(double t, double force);

  /// The impulse until a time, N s.
  [[nodiscard]] double until(double t) const;
  [[nodiscard]] double total() const { return sums_.back(); }
  /// The mean force between two times, N.
  [[nodiscard]] double mean(double from, double to) const { return (until(to) - until(from)) / (to - from); }
  /// The times at which the impulse reaches the parts `from` and `to` of the whole; 0 and 0 without any.
  [[nodiscard]] std::pair<double, double> between(double from, double to) const;
  /// The time in which the impulse grows from 1 to 99 % of the whole, s.
  [[nodiscard]] double duration() const;
  /// A mean force (N), the length of its window and the window's end (s).
  struct Mean {
    double force = 0, over = 0, end = 0;
  };
  /// The largest mean over `window` (s), or over two steps where these take longer.
  [[nodiscard]] Mean largest_mean(double window) const;
  /// The largest mean over `window`, compared with the largest ones over other windows. The excess of a
  /// smooth force over its means grows as the square of the window. It is at most that of half a sine of the
  /// impulse's duration, and at most a quarter of the excess of means over twice the window over those over
  /// four times the window.
  struct Peak {
    Mean mean;
    double twice = 0;    ///< the largest mean force over twice mean.over, N
    double excess = 0;   ///< excess of mean.force over `twice`, relative
    double expected = 0; ///< the excess that a smooth force may have
    bool smooth = false; ///< whether means over mean.over / 2 exceed it by at most (mean.force − twice)/2
  };
  /// Compares the largest means of a record whose total() is not zero.
  [[nodiscard]] Peak peak(double window) const;

  /// Ends of steps, without those inside an interval free of force, s.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }

private:
  std::vector<double> times_{0}, sums_{0}, lengths_{0}; ///< ends of steps, impulse until then, last step (s)
  double end_ = 0;                                      ///< end of the last step added, s
};

} // namespace signorini::trajectory
