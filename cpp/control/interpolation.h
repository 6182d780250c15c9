// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control.h"
#include "control/control_space.h"
#include "fem/sampler.h"

namespace signorini::control {

/// Transfers controls from one space to another. The spaces may differ in their meshes of the body, in
/// degree, kind of values and time steps.
///
/// In space it is finite-element interpolation: the function is evaluated at each place (node or midpoint) of
/// the target space. A place just outside the mesh takes the polynomial of the nearest cell. A place on a
/// surface takes the value at the nearest point of the source's surface. In time each target interval takes
/// the mean over its duration, which is the L2 projection. If the target's intervals subdivide the source's,
/// values are repeated and products of controls are preserved.
class Interpolation {
public:
  /// Prepares the transfer from the space `from` to the space `to`. Both must outlive this object, and their
  /// controls must act on sets of the same dimension. Collective.
  Interpolation(const ControlSpace& from, const ControlSpace& to);

  /// Returns the largest distance of a place of the target space from the set on which controls of the source
  /// space act, m.
  [[nodiscard]] double farthest() const;

  /// Returns the control u transferred to the target space. Collective.
  [[nodiscard]] Control operator()(const Control& u) const;
  /// Returns v with its control transferred to the target space; parameters are the same on every mesh.
  [[nodiscard]] Variables operator()(const Variables& v) const { return {(*this)(v.u), v.x}; }

private:
  const ControlSpace& from_;
  const ControlSpace& to_;
  std::size_t first_ = 0; ///< index of this rank's first target place among those of all ranks
  fem::Sampler sampler_;
};

} // namespace signorini::control
