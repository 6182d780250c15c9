// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <array>
#include <boost/numeric/interval.hpp>
#include <functional>
#include <string>
#include <vector>

namespace signorini::scene {

/// A range of numbers, either end of which may be infinite.
using Interval = boost::numeric::interval<
    double,
    boost::numeric::interval_lib::policies<boost::numeric::interval_lib::save_state_nothing<
                                               boost::numeric::interval_lib::rounded_transc_exact<double>>,
                                           boost::numeric::interval_lib::checking_base<double>>>;

/// Ranges of x, y, z (m) and t (s).
using Box = std::array<Interval, 4>;

/// Bounds of an expression over a box, which no sampling can give, and the times at which it changes. Reads
/// the language of muParser, by which Field evaluates. Ends are rounded to nearest.
class Enclosure {
public:
  /// Makes an enclosure of no expression: known() is false.
  Enclosure() = default;
  /// Reads an expression that muParser has accepted; known() is false if this class cannot read it.
  explicit Enclosure(const std::string& expression);

  [[nodiscard]] bool known() const { return known_; }
  /// Range of values over a box, or a larger one: all numbers if the expression is not known.
  [[nodiscard]] Interval operator()(const Box& box) const;
  /// Times (s) at which t passes a number that it is compared with, in no order.
  [[nodiscard]] const std::vector<double>& knots() const { return knots_; }

private:
  std::function<Interval(const Box&)> range_;
  std::vector<double> knots_;
  bool known_ = false;
};

} // namespace signorini::scene
