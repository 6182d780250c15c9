// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/mesh.h"
#include "mesh/raw_mesh.h"

/// gmsh in a process of its own, the program signorini-gmsh, since it may crash on a damaged file.
namespace signorini::mesh {

/// Runs read_gmsh_here() in a process of its own. Also throws UserError if gmsh crashes, and Interrupted if
/// this process was asked to stop meanwhile. Not collective: call it on one rank.
RawMesh read_gmsh(const scene::Mesh& mesh, const Meshing& meshing = {});

/// Runs write_msh_here() in a process of its own. Throws UserError. Not collective.
void write_msh(const RawMesh& mesh, const std::filesystem::path& file, scene::LengthUnit unit);

} // namespace signorini::mesh
