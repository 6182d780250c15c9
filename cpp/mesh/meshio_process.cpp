// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/meshio_process.h"
#include "base/error.h"
#include "base/subprocess.h"
#include "mesh/gmsh_request.h"
#include <fmt/format.h>
#include <fstream>

namespace signorini::mesh {

std::string read_by_meshio(const std::filesystem::path& file) {
  const auto fail = [&](const std::string& why) {
    return UserError(fmt::format("{}: {}", file.string(), why));
  };
  if (!std::ifstream(file) || std::filesystem::is_directory(file))
    throw UserError(
        fmt::format("mesh.file: {} cannot be read; give the path of a mesh or a geometry", file.string()));
  std::optional<std::string> answer;
  try {
    answer = in_subprocess(python_command("mesh_file.py"), file.string());
  } catch (const std::runtime_error& error) {
    throw fail(fmt::format("{}; files of this format are read by Python with meshio", error.what()));
  }
  if (!answer || answer->empty())
    throw fail("Python with meshio ends on this file without an answer; check that the file is complete, or "
               "convert it to .msh");
  if (answer->front() == failed)
    throw fail(answer->substr(1));
  return answer->substr(1);
}

} // namespace signorini::mesh
