// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/mesh.h"
#include "mesh/raw_mesh.h"

/// gmsh in this process, which a damaged file may crash; see mesh/gmsh_process.h.
namespace signorini::mesh {

/// Reads a .msh, or meshes a .geo with the scene's size or scale. A .geo is meshed up to the dimension of its
/// highest entities: triangles in the plane z = 0, or tetrahedra. Throws UserError for a file that cannot be
/// read or has a wrong dimension or element type. Throws it, too, for cells that are degenerate, overlap
/// their neighbours or are in no physical group, and for boundary groups with facets of no cell.
RawMesh read_gmsh_here(const scene::Mesh& mesh, const Meshing& meshing = {});

/// Writes a mesh with its parts and boundary groups, in a unit of length, as a .msh. Groups without elements
/// and those of lower dimensions are left out. Throws std::exception.
void write_msh_here(const RawMesh& mesh, const std::filesystem::path& file, scene::LengthUnit unit);

} // namespace signorini::mesh
