// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/enclosure.h"
#include "scene/scene.h"
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace signorini::scene {

/// Description of the operators, functions and constants of expressions, for users.
const std::string& expression_parts();

/// A vector field whose components are expressions (muParser) of x, y, z (m) and t (s) or time series. Not
/// collective.
class Field {
public:
  /// Parses the expressions of the components. `time`: whether the expressions may depend on t. Throws
  /// UserError, naming `key`, if an expression does not parse or uses an unknown variable.
  Field(Components components, const std::string& key, bool time);
  ~Field();
  Field(Field&&) noexcept;
  Field& operator=(Field&&) noexcept;

  /// Number of components.
  [[nodiscard]] std::size_t size() const;
  /// Whether any component uses t or is a time series.
  [[nodiscard]] bool depends_on_time() const;
  [[nodiscard]] bool depends_on_time(std::size_t component) const;
  /// Whether any component uses x, y or z.
  [[nodiscard]] bool depends_on_place() const;
  [[nodiscard]] bool depends_on_place(std::size_t component) const;
  /// Key of the scene that gives the field, for messages.
  [[nodiscard]] const std::string& key() const;

  /// Evaluates all components at the point `x` (3), m, and time `t`, s, into `values` (size()). Throws
  /// UserError, naming key, point and time, if a value is not finite.
  void evaluate(const double* x, double t, double* values) const;
  /// Value of one component at the point `x` (3), m, and time `t`, s. Throws UserError like evaluate().
  [[nodiscard]] double value(std::size_t component, const double* x, double t) const;

  /// Time series of a component, null for an expression.
  [[nodiscard]] const TimeSeries* series(std::size_t component) const;
  /// Bounds of the values in `box` of a component that is an expression.
  [[nodiscard]] Interval enclose(std::size_t component, const Box& box) const;
  /// Times (s), unsorted, at which the components' expressions may jump or have kinks (Enclosure::knots()).
  [[nodiscard]] std::vector<double> knots() const;

  /// Rate of change at time t (s) of a component that is a time series, per second, as TimeSeries::slope()
  /// defines it; absent for an expression.
  [[nodiscard]] std::optional<double> slope(std::size_t component, double t, bool after) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace signorini::scene
