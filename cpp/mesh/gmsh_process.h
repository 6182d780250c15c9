// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/mesh.h"
#include "mesh/raw_mesh.h"

/// Use of gmsh in a separate process, the program signorini-gmsh, since a damaged file may crash gmsh.
namespace signorini::mesh {

/// Runs read_gmsh_here() in a separate process. Throws UserError also if gmsh crashes, and Interrupted if a
/// stop of this process is requested meanwhile. Not collective: call it on one rank.
RawMesh read_gmsh(const scene::Mesh& mesh, const Meshing& meshing = {});

/// Runs write_msh_here() in a separate process. Throws UserError if that fails. Not collective: call it on
/// one rank.
void write_msh(const RawMesh& mesh, const std::filesystem::path& file, scene::LengthUnit unit);

} // namespace signorini::mesh
