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

/// Bounds of an expression over a box, and the times at which the expression may have a jump or a kink. The
/// bounds are computed by interval arithmetic and, unlike samples, are valid at all points. The language is
/// that of muParser, with which Field evaluates expressions. The ends of intervals are rounded to nearest.
class Enclosure {
public:
  /// Makes an enclosure without an expression: known() is false.
  Enclosure() = default;
  /// Reads an expression that muParser has accepted; known() is false if the expression has parts that this
  /// class does not support.
  explicit Enclosure(const std::string& expression);

  /// Whether an expression was read.
  [[nodiscard]] bool known() const { return known_; }
  /// Interval that contains all values of the expression in a box; the interval of all numbers if known() is
  /// false.
  [[nodiscard]] Interval operator()(const Box& box) const;
  /// Times (s), unsorted, at which the expression may have a jump or a kink, because two compared parts of it
  /// are equal: the operands of a comparison, the arguments of a function such as max, or 0 and the argument
  /// of abs or sign. Only parts that are linear functions of t alone count.
  [[nodiscard]] const std::vector<double>& knots() const { return knots_; }

private:
  std::function<Interval(const Box&)> range_;
  std::vector<double> knots_;
  bool known_ = false;
};

} // namespace signorini::scene
