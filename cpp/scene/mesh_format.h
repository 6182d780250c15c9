// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <optional>
#include <string>

namespace signorini::scene {

/// Kinds of mesh files. script: a .geo of gmsh; shape: CAD, which has no mesh either; msh: a mesh of gmsh;
/// gmsh: a mesh of another program that gmsh reads; meshio: one that meshio reads.
enum class MeshFormat { script, shape, msh, gmsh, meshio };

/// Kind of a file by its extension, in capitals too; absent if the program reads no such files.
std::optional<MeshFormat> mesh_format(const std::filesystem::path& file);

/// Whether a file of this extension says in which unit its lengths are: CAD other than .brep.
bool names_its_unit(const std::filesystem::path& file);

/// Extensions of all files that the program reads, as a list for messages.
std::string mesh_extensions();

} // namespace signorini::scene
