// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

namespace signorini::trajectory {

/// Windows over which a peak force is a mean, in times in which a wave crosses an element in contact.
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
  /// The times between which the impulse grows from a part of the whole to another; 0 and 0 without any.
  [[nodiscard]] std::pair<double, double> between(double from, double to) const;
  /// The time in which the impulse grows from 1 to 99 % of the whole, s.
  [[nodiscard]] double duration() const;
  /// A mean force (N), the time over which it is one, and the end of that (s).
  struct Mean {
    double force = 0, over = 0, end = 0;
  };
  /// The largest mean over `window` (s), or over two steps where these take longer.
  [[nodiscard]] Mean largest_mean(double window) const;
  /// The largest mean over `window`, beside the largest ones over other times. A smooth force exceeds its
  /// means by the square of their window: by no more than half a sine of the impulse's duration does, and a
  /// quarter of what means over twice the time exceed those over four times it.
  struct Peak {
    Mean mean;
    double twice = 0;    ///< force, the largest mean over twice mean.over, N
    double excess = 0;   ///< of mean.force over that, relative
    double expected = 0; ///< the excess that a smooth force may have
    bool smooth = false; ///< whether means over half the time exceed it by no more than half of that
  };
  /// Of a record whose total() is not zero.
  [[nodiscard]] Peak peak(double window) const;

  /// Ends of steps, but for those within a time without a force, s.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }

private:
  std::vector<double> times_{0}, sums_{0}, lengths_{0}; ///< ends of steps, impulse until then, last step (s)
  double end_ = 0;                                      ///< of the last step added, s
};

} // namespace signorini::trajectory
