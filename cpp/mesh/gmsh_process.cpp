// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh_process.h"
#include "base/error.h"
#include "base/subprocess.h"
#include "mesh/gmsh_request.h"
#include "mesh/meshio_process.h"
#include <fmt/format.h>

namespace signorini::mesh {
namespace {

/// `seconds`: limit on the processor time of the answer; 0: none.
std::optional<std::string> ask(const GmshRequest& request, unsigned seconds = 0) {
  return in_subprocess({find_program("signorini-gmsh"), std::to_string(seconds)}, packed(request));
}

} // namespace

void write_msh(const RawMesh& mesh, const std::filesystem::path& file, scene::LengthUnit unit) {
  const std::optional<std::string> said = ask({.mesh{.file = file, .size{}, .unit = unit}, .written = mesh});
  if (!said || !said->starts_with(done))
    throw UserError(fmt::format("{}: gmsh cannot write it ({}); choose another file", file.string(),
                                said && !said->empty() ? said->substr(1) : "it crashes"));
}

RawMesh read_gmsh(const scene::Mesh& mesh, const Meshing& meshing) {
  // gmsh trusts the counts in a damaged file and may never end; it reads tens of megabytes per second.
  unsigned seconds = 0;
  if (std::error_code missing; mesh.meshed())
    if (const auto size = std::filesystem::file_size(mesh.file, missing); !missing)
      seconds = 5 + static_cast<unsigned>(size / 1'000'000);
  GmshRequest request{.mesh = mesh, .keep = meshing.keep};
  if (mesh.format() == scene::MeshFormat::meshio)
    request.msh = read_by_meshio(mesh.file);
  if (meshing.sizes)
    request.sizes = *meshing.sizes;
  const std::optional<std::string> answer = ask(request, seconds);
  if (!answer)
    throw UserError(
        fmt::format("{}: gmsh crashes on this file or does not finish; check that the file is complete",
                    mesh.file.string()));
  if (answer->empty())
    throw UserError(
        fmt::format("{}: gmsh stopped before the end of this file; remove the command that stops it, such as "
                    "Exit",
                    mesh.file.string()));
  if (answer->front() == failed)
    throw UserError(answer->substr(1));
  return unpacked(std::string_view(*answer).substr(1));
}

} // namespace signorini::mesh
