// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/raw_mesh.h"
#include "mesh/size_field.h"
#include <filesystem>
#include <optional>
#include <string>

namespace signorini::mesh {

/// What the program signorini-gmsh is asked for: to read or mesh a file, or to write one.
struct GmshRequest {
  scene::Mesh mesh; ///< the file and how it is meshed; its degree does not matter
  std::optional<SizeField> sizes{};
  std::filesystem::path keep{};
  std::optional<RawMesh> written{}; ///< to the file, in place of reading it
};

std::string packed(const GmshRequest& request);

/// Inverse of packed(). Throws std::exception.
GmshRequest request_of(const std::string& bytes);

/// First byte of an answer: the mesh, packed, or nothing; or an error.
constexpr char done = 'm', failed = 'e';

} // namespace signorini::mesh
