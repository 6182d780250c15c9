// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/raw_mesh.h"
#include "mesh/size_field.h"

namespace signorini::mesh {

/// Refines a mesh by dividing edges, in at most 30 rounds, until no edge is longer than √2 times the size
/// wanted there: the entry of `sizes` at the node of the field that is nearest to the edge's midpoint
/// (dolfinx; A. Plaza, G. F. Carey, *Local refinement of simplicial grids based on the skeleton*, Appl.
/// Numer. Math. 32 (2000)). Parts and boundary groups are transferred. The boundary keeps its shape: a curved
/// one remains the polygon of the given mesh. Not collective.
RawMesh refined(RawMesh mesh, const SizeField& sizes);

} // namespace signorini::mesh
