// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/raw_mesh.h"
#include "mesh/size_field.h"
#include <filesystem>
#include <optional>
#include <string>

namespace signorini::mesh {

/// Request to the program signorini-gmsh: to read or mesh a file, or to write one.
struct GmshRequest {
  scene::Mesh mesh; ///< the file and how it is meshed; its degree does not matter
  std::optional<SizeField> sizes{};
  std::filesystem::path keep{};
  std::optional<RawMesh> written{}; ///< mesh to write to the file, in place of reading it
};

std::string packed(const GmshRequest& request);

/// Inverse of packed(). Throws std::exception.
GmshRequest request_of(const std::string& bytes);

/// First byte of an answer: `done`, followed by the packed mesh if there is one, or `failed`, followed by the
/// error.
constexpr char done = 'm', failed = 'e';

} // namespace signorini::mesh
