// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

namespace signorini::trajectory {

/// Length of the window for a sustained peak force, in units of the time in which a wave crosses an element
/// in contact.
constexpr double sustained = 4;

/// Record of a force that is constant in each step. Its impulse and means converge as the steps become
/// shorter; its values in single steps do not (docs/method.md section 8).
class ImpulseRecord {
public:
  /// Appends a step that ends at time `t` (s), with its force (N).
  void add(double t, double force);

  /// Returns the impulse until time `t` (s), N s.
  [[nodiscard]] double until(double t) const;
  /// Returns the impulse of all steps, N s.
  [[nodiscard]] double total() const { return sums_.back(); }
  /// Returns the mean force between two times (s), N.
  [[nodiscard]] double mean(double from, double to) const { return (until(to) - until(from)) / (to - from); }
  /// Returns the times (s) at which the impulse reaches the fractions `from` and `to` of total(); (0, 0) if
  /// total() is not positive.
  [[nodiscard]] std::pair<double, double> between(double from, double to) const;
  /// Returns the time in which the impulse grows from 1 to 99 % of total(), s.
  [[nodiscard]] double duration() const;
  /// Mean force over a time window (N), with the length and the end of the window (s).
  struct Mean {
    double force = 0, over = 0, end = 0;
  };
  /// Returns the largest mean force over time windows of length `window` (s), or of two steps where these are
  /// longer.
  [[nodiscard]] Mean largest_mean(double window) const;
  /// Comparison of the largest mean force F(w) over windows of length w with those over w/2, 2 w and 4 w. For
  /// a smooth force, F(w) is less than the peak by a term proportional to w². Two bounds for the excess
  /// F(w)/F(2 w) − 1 follow: (F(2 w) − F(4 w))/(4 F(2 w)), and the excess of a half sine that lasts as long
  /// as the impulse.
  struct Peak {
    Mean mean;           ///< F(w) with its window
    double twice = 0;    ///< F(2 w), N
    double excess = 0;   ///< F(w)/F(2 w) − 1
    double expected = 0; ///< largest excess of a smooth force: the lower one of the bounds
    bool smooth = false; ///< whether F(w/2) − F(w) is at most (F(w) − F(2 w))/2
  };
  /// Returns the comparison of largest means for windows of length `window` (s). total() must not be zero.
  [[nodiscard]] Peak peak(double window) const;

  /// Returns the time 0 and the ends of the steps, s. Ends of steps inside an interval without force are
  /// omitted.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }

private:
  /// Ends of steps (s), impulse until then (N s), length of the step (s).
  std::vector<double> times_{0}, sums_{0}, lengths_{0};
  double end_ = 0; ///< end of the last step added, s
};

} // namespace signorini::trajectory
