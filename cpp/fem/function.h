// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/dolfinx_versions.h"
#include <algorithm>
#include <dolfinx/fem/Function.h>
#include <span>

namespace signorini::fem {

using Function = dolfinx::fem::Function<double>;

/// Sets a function's values from those that this rank owns. Collective.
inline void set(Function& to, std::span<const double> owned) {
  std::ranges::copy(owned, dolfinx_versions::entries(*to.x()).begin());
  to.x()->scatter_fwd();
}

} // namespace signorini::fem
