// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/mesh.h"
#include "scene/scene.h"
#include <cstdint>
#include <vector>

namespace signorini::fem {

/// A part of the body and its material.
struct Part {
  scene::Material material;
  std::vector<std::int32_t> cells; ///< those that this rank owns, local indices
};

/// The parts of the body, one for each material. Collective. Throws UserError, on every rank alike, if a
/// material's group is missing or empty, or if a cell is in none of the groups or in two of them.
std::vector<Part> parts(const mesh::Mesh& mesh, const std::vector<scene::Material>& materials);

} // namespace signorini::fem
