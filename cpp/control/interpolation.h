// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control.h"
#include "control/control_space.h"
#include "fem/sampler.h"

namespace signorini::control {

/// Transfers controls from one space to another, on another mesh of the same body or with another degree,
/// kind of values or time step, on any number of ranks. In space it is finite-element interpolation: the
/// function is evaluated at each place of the other space. A place just outside of the mesh takes the
/// polynomial of the nearest cell; on a surface it takes the nearest point of that. In time each step has the
/// mean over its duration. That is the L2 projection: it repeats values where steps are whole parts of longer
/// ones, and so keeps products of controls there.
class Interpolation {
public:
  /// The spaces must outlive this object. Throws UserError if one of them acts by a force on a surface and
  /// the other in the body. Collective.
  Interpolation(const ControlSpace& from, const ControlSpace& to);

  /// The largest distance of a place of `to` from the set on which controls of `from` act, m.
  [[nodiscard]] double farthest() const;

  /// Interpolates a control. Collective.
  [[nodiscard]] Control operator()(const Control& u) const;
  /// Interpolates the control; parameters are the same on every mesh.
  [[nodiscard]] Variables operator()(const Variables& v) const { return {(*this)(v.u), v.x}; }

private:
  const ControlSpace& from_;
  const ControlSpace& to_;
  std::size_t first_ = 0; ///< index of this rank's first place among those of all ranks
  fem::Sampler sampler_;
};

} // namespace signorini::control
