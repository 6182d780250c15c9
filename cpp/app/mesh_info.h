// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include <filesystem>
#include <mpi.h>
#include <string>
#include <vector>

namespace signorini::app {

/// Whether the file is a mesh or a geometry, not a scene, by its extension.
bool is_mesh(const std::filesystem::path& file);

/// Runs the verb info on a mesh or a geometry: prints sizes, quality, connected parts and groups.
/// `overrides`: arguments `mesh.key=value` of --set; without mesh.size a geometry is meshed coarsely, or as a
/// .geo asks. Throws UserError. Collective.
void print_mesh_info(MPI_Comm comm, const std::filesystem::path& file,
                     const std::vector<std::string>& overrides, const Console& console);

} // namespace signorini::app
