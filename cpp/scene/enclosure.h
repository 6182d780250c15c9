// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <array>
#include <boost/numeric/interval.hpp>
#include <functional>
#include <string>
#include <vector>

namespace signorini::scene {

/// An interval of numbers, either end of which may be infinite.
using Interval = boost::numeric::interval<
    double,
    boost::numeric::interval_lib::policies<boost::numeric::interval_lib::save_state_nothing<
                                               boost::numeric::interval_lib::rounded_transc_exact<double>>,
                                           boost::numeric::interval_lib::checking_base<double>>>;

/// Intervals of x, y, z (m) and t (s).
using Box = std::array<Interval, 4>;

/// Computes bounds of an expression over a box by interval arithmetic, which hold at all points unlike
/// samples, and the times at which the expression may change. Reads the language of muParser, with which
/// Field evaluates expressions. The ends of intervals are rounded to nearest.
class Enclosure {
public:
  /// Makes an enclosure without an expression: known() is false.
  Enclosure() = default;
  /// Reads an expression that muParser has accepted; known() is false if the expression has parts that this
  /// class does not support.
  explicit Enclosure(const std::string& expression);

  /// Whether an expression was read.
  [[nodiscard]] bool known() const { return known_; }
  /// Interval that contains all values of the expression in a box; all numbers unless known().
  [[nodiscard]] Interval operator()(const Box& box) const;
  /// Times (s) at which the result of a comparison in the expression changes, unsorted. Only comparisons
  /// between linear functions of t count.
  [[nodiscard]] const std::vector<double>& knots() const { return knots_; }

private:
  std::function<Interval(const Box&)> range_;
  std::vector<double> knots_;
  bool known_ = false;
};

} // namespace signorini::scene
