// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <array>
#include <cmath>

namespace signorini {

/// Point or vector in space; in the plane the third component is zero.
using Point = std::array<double, 3>;

inline double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline double length(const Point& a) { return std::hypot(a[0], a[1], a[2]); }

/// Returns x + s d.
inline Point along(const Point& x, double s, const Point& d) {
  return {x[0] + s * d[0], x[1] + s * d[1], x[2] + s * d[2]};
}

inline Point scaled(double s, const Point& a) { return {s * a[0], s * a[1], s * a[2]}; }

/// Returns the vector x − a, which leads from `a` to `x`.
inline Point from(const Point& a, const Point& x) { return {x[0] - a[0], x[1] - a[1], x[2] - a[2]}; }

inline Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

} // namespace signorini
