// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

namespace signorini::contact {

/// Returns two unit vectors normal to the unit vector ν and to each other, of which the first one is in a
/// coordinate plane where that is possible, as planes of symmetry often are; in the plane one unit vector and
/// zero. `dim`: dimension of the bodies; in the plane the third component of ν is zero.
[[nodiscard]] inline std::array<std::array<double, 3>, 2> tangents(const std::array<double, 3>& nu, int dim) {
  using Vector = std::array<double, 3>;
  if (dim == 2)
    return {Vector{-nu[1], nu[0], 0}, Vector{}};
  const auto least = static_cast<std::size_t>(
      std::ranges::min_element(nu, {}, [](double component) { return std::abs(component); }) - nu.begin());
  Vector first{};
  double length = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    first[c] = (c == least) - nu[least] * nu[c];
    length = std::hypot(length, first[c]);
  }
  for (double& component : first)
    component /= length;
  return {first, Vector{nu[1] * first[2] - nu[2] * first[1], nu[2] * first[0] - nu[0] * first[2],
                        nu[0] * first[1] - nu[1] * first[0]}};
}

} // namespace signorini::contact
