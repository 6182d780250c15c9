// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/worker.h"
#include "mesh/gmsh_model.h"
#include "mesh/gmsh_process.h"
#include <exception>

// The program signorini-gmsh.

namespace signorini::mesh {
namespace {

std::string answer(const std::string& bytes) {
  try {
    const GmshRequest request = request_of(bytes);
    if (request.written) {
      write_msh_here(*request.written, request.mesh.file, request.mesh.unit);
      return {done};
    }
    const Meshing meshing{.sizes = request.sizes ? &*request.sizes : nullptr, .keep = request.keep};
    return done + packed(read_gmsh_here(request.mesh, meshing));
  } catch (const std::exception& error) {
    return failed + std::string(error.what());
  }
}

} // namespace
} // namespace signorini::mesh

int main() { return signorini::worker::serve(signorini::mesh::answer); }
