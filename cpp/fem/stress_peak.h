// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/forms.h"

namespace signorini::fem {

/// The largest von Mises stress of the cells, and how far the cells around make out the same.
struct StressPeak {
  Largest largest;      ///< Pa, at the middle of the cell
  double recovered = 0; ///< Pa, there, of the stress that is linear with the means, by volume, of the cells
                        ///< of one material at a node
  /// A node of the cell on the boundary, m: that with the largest angle if the boundary has a corner there
  /// that points into the body, else that with the largest stress around it.
  std::optional<std::array<double, 3>> corner;
  double angle = 0; ///< of the body around it, as a part of the full one: ½ where the boundary is smooth
};

/// Part of the full angle around a node of the boundary: beyond it the boundary has a corner that points
/// into the body, by 30 degrees or more.
constexpr double reentrant = 0.5 + 1.0 / 12;

/// Of the last motion set in `fields`, which are those of the body's `parts`. Collective.
StressPeak stress_peak(const Space& space, const std::vector<Part>& parts, CellFields& fields);

} // namespace signorini::fem
