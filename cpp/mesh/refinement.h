// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/raw_mesh.h"
#include "mesh/size_field.h"

namespace signorini::mesh {

/// Refines a mesh by dividing edges until none is longer than √2 times the size of a field at its midpoint
/// (dolfinx; A. Plaza, G. F. Carey, *Local refinement of simplicial grids based on the skeleton*, Appl.
/// Numer. Math. 32 (2000)). Its parts, boundary groups and boundary are kept: a curved boundary stays the
/// polygon of the given mesh. Not collective.
RawMesh refined(RawMesh mesh, const SizeField& sizes);

} // namespace signorini::mesh
