// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace signorini::scene {

/// A unit of measurement, expressed in SI units.
struct Unit {
  double factor = 1;              ///< value of the unit in SI units
  std::array<int, 3> dimension{}; ///< exponents of m, kg and s

  friend bool operator==(const Unit& a, const Unit& b) = default;
};

/// Parses a unit such as `ms`, `kN`, `N/mm²`, `m/s^2` or `N s`: a product of m, g, s, min, h, N and Pa with
/// SI prefixes and whole exponents. Absent if the text is not such a unit.
std::optional<Unit> unit(std::string_view text);

/// Limits and unit of a number, for validation and messages.
struct Limits {
  double least = -std::numeric_limits<double>::infinity();
  double greatest = std::numeric_limits<double>::infinity();
  bool open = false; ///< whether the limits themselves are excluded
  std::string unit{};

  /// Whether a value is finite and within the limits.
  [[nodiscard]] bool contain(double value) const;
  /// Limits in words after a space, such as " of at least 0 and at most 1"; empty without limits.
  [[nodiscard]] std::string range() const;
};

} // namespace signorini::scene
