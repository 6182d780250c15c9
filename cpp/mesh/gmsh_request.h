// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/raw_mesh.h"
#include "mesh/size_field.h"
#include <filesystem>
#include <optional>
#include <string>

namespace signorini::mesh {

/// Request to the program signorini-gmsh: either to read or mesh a file, or to write one.
struct GmshRequest {
  scene::Mesh mesh; ///< the file, and how to mesh it
  std::optional<SizeField> sizes{};
  std::filesystem::path keep{};
  std::optional<std::string>
      msh{}; ///< text of a .msh to read in place of the file, which was converted to it
  std::optional<RawMesh> written{}; ///< mesh to write to the file; absent for requests to read
};

std::string packed(const GmshRequest& request);

/// Decodes the request from the result of packed(). Throws std::exception if the bytes are invalid.
GmshRequest request_of(const std::string& bytes);

/// First byte of an answer: after `done` follows the packed mesh, if the request was to read; after `failed`
/// follows the text of the error.
constexpr char done = 'm', failed = 'e';

} // namespace signorini::mesh
