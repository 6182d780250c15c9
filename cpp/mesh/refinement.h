// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/raw_mesh.h"
#include "mesh/size_field.h"

namespace signorini::mesh {

/// A mesh whose edges are no longer than √2 times the sizes of a field at their midpoints, by dividing edges
/// (dolfinx; A. Plaza, G. F. Carey, *Local refinement of simplicial grids based on the skeleton*, Appl.
/// Numer. Math. 32 (2000)). Its parts and boundary groups are those of the one given, and so is its boundary:
/// of a curve it knows the polygon alone. Not collective.
RawMesh refined(RawMesh mesh, const SizeField& sizes);

} // namespace signorini::mesh
