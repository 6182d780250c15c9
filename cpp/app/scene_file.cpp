// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/scene_file.h"
#include "base/collective.h"

namespace signorini::app {
namespace {

/// Folder of the run that wrote the scene file as its echo, beside run.json; empty for other scenes.
std::string folder_of_echo(const std::filesystem::path& file) {
  const std::filesystem::path absolute = std::filesystem::absolute(file).lexically_normal(),
                              folder = absolute.parent_path();
  std::error_code none;
  return absolute.filename() == "scene.toml" && std::filesystem::exists(folder / "run.json", none)
             ? folder.string()
             : "";
}

} // namespace

scene::Scene parse_scene(MPI_Comm comm, const std::string& text, const std::filesystem::path& file,
                         const std::vector<std::string>& overrides) {
  const auto open =
      [comm](const std::filesystem::path& series) { // every rank reads the same, in the same order
        std::string content;
        on_root(comm, [&] { content = scene::read_file(series); });
        return broadcast(comm, content);
      };
  scene::Scene scene = scene::parse(text, file, overrides, open);
  // Its default depends on the machine, and all ranks must choose the same solvers.
  MPI_Allreduce(MPI_IN_PLACE, &scene.solver.memory, 1, MPI_DOUBLE, MPI_MIN, comm);
  return scene;
}

SceneFile read_scene(MPI_Comm comm, const std::filesystem::path& file,
                     const std::vector<std::string>& overrides) {
  std::string text, run_folder;
  on_root(comm, [&] { text = scene::read(file); });
  text = broadcast(comm, text);
  SceneFile found{.scene = parse_scene(comm, text, file, overrides), .text = text, .run_folder = {}};
  on_root(comm, [&] { run_folder = folder_of_echo(file); });
  found.run_folder = broadcast(comm, run_folder);
  if (!found.run_folder.empty())
    found.scene.name = found.run_folder.filename().string();
  return found;
}

} // namespace signorini::app
