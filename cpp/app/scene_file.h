// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <filesystem>
#include <mpi.h>
#include <string>
#include <vector>

namespace signorini::app {

/// A scene as it was read from its file.
struct SceneFile {
  scene::Scene scene;
  std::string text;
  std::filesystem::path home; ///< folder of the run that wrote the file as its echo; empty for other scenes
};

/// Reads a scene, on rank 0 for all: ranks with different scenes would deadlock. `overrides`:
/// `key.path=value`. Collective. Throws UserError.
SceneFile read_scene(MPI_Comm comm, const std::filesystem::path& file,
                     const std::vector<std::string>& overrides);

} // namespace signorini::app
