// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/mesh.h"
#include "mesh/raw_mesh.h"
#include <optional>
#include <string>

/// Use of gmsh within this process, which a damaged file may crash; see mesh/gmsh_process.h.
namespace signorini::mesh {

/// Reads a mesh, or meshes a geometry with the scene's size or scale, up to the dimension of its highest
/// entities: triangles in the plane z = 0, or tetrahedra. `msh`: text of a .msh to which the file was
/// converted. Throws UserError if the file cannot be read or has a wrong dimension or element type, or if
/// cells are degenerate, overlap their neighbours or are in no physical group though others are. A boundary
/// group with an element that is a facet of no cell is returned as unusable.
RawMesh read_gmsh_here(const scene::Mesh& mesh, const Meshing& meshing = {},
                       const std::optional<std::string>& msh = {});

/// Writes a mesh with its parts and boundary groups as a .msh file, with coordinates in `unit`. Omits groups
/// without elements and groups of lower dimensions. Throws std::exception.
void write_msh_here(const RawMesh& mesh, const std::filesystem::path& file, scene::LengthUnit unit);

} // namespace signorini::mesh
