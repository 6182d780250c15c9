// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/dolfinx_versions.h"
#include <algorithm>
#include <dolfinx/fem/Function.h>
#include <span>

namespace signorini::fem {

using Function = dolfinx::fem::Function<double>;

/// Sets a function's values from the values at the dofs that this rank owns, and updates ghosts. Values of
/// virtual nodes (VirtualNode), which follow those of the mesh's nodes, are ignored. Collective.
inline void set(Function& to, std::span<const double> owned) {
  const auto own = static_cast<std::size_t>(to.function_space()->dofmap()->index_map->size_local() *
                                            to.function_space()->dofmap()->index_map_bs());
  std::ranges::copy(owned.first(std::min(own, owned.size())), dolfinx_versions::entries(*to.x()).begin());
  to.x()->scatter_fwd();
}

} // namespace signorini::fem
