// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <filesystem>
#include <mpi.h>
#include <string>
#include <vector>

namespace signorini::app {

/// A scene and the file from which it was read.
struct SceneFile {
  scene::Scene scene;
  std::string text; ///< text of the file
  /// Folder of the file if an earlier run wrote it as its scene.toml, else empty.
  std::filesystem::path run_folder;
};

/// Parses the text of a scene file on all ranks; the files that it names are read on rank 0. `overrides`:
/// arguments `key.path=value` of --set. Throws UserError. Collective.
scene::Scene parse_scene(MPI_Comm comm, const std::string& text, const std::filesystem::path& file,
                         const std::vector<std::string>& overrides);

/// Reads a scene file on rank 0 and parses it on all ranks, since ranks with different scenes would deadlock.
/// `overrides`: arguments `key.path=value` of --set. Throws UserError. Collective.
SceneFile read_scene(MPI_Comm comm, const std::filesystem::path& file,
                     const std::vector<std::string>& overrides);

} // namespace signorini::app
