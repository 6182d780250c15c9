#pragma once
#include "mesh/raw_mesh.h"
#include "scene/scene.h"

namespace signorini::mesh {

/// Reads a .msh, or meshes a .geo at its size. Not collective: call it on one rank.
/// A .geo is meshed up to the dimension of its highest entities: triangles in the plane z = 0, or tetrahedra.
/// Throws UserError for a file that cannot be read, a wrong dimension or element type, cells that are flat,
/// overlap their neighbours or are in no physical group, and boundary groups of other facets than the cells'.
/// gmsh, which may crash on a damaged file, works in a process of its own: then it throws UserError too.
RawMesh read_gmsh(const scene::Mesh& mesh);

/// The same in this process.
RawMesh read_gmsh_here(const scene::Mesh& mesh);

} // namespace signorini::mesh
