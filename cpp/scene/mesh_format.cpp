// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/mesh_format.h"
#include "base/text.h"
#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

namespace signorini::scene {

namespace {

using enum MeshFormat;
constexpr std::initializer_list<std::pair<std::string_view, MeshFormat>> extensions{
    {".geo", script}, {".msh", msh},    {".step", shape}, {".stp", shape},  {".iges", shape},
    {".igs", shape},  {".brep", shape}, {".unv", gmsh},   {".bdf", meshio}, {".nas", meshio},
    {".inp", meshio}, {".med", meshio}, {".vtu", meshio}, {".vtk", meshio}, {".xdmf", meshio},
    {".e", meshio},   {".exo", meshio}};

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

} // namespace

std::optional<MeshFormat> mesh_format(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  for (const auto& [known, format] : extensions)
    if (known == extension)
      return format;
  return std::nullopt;
}

bool names_its_unit(const std::filesystem::path& file) {
  return mesh_format(file) == shape && lower_extension(file) != ".brep";
}

std::string mesh_extensions() {
  std::vector<std::string> names;
  for (const auto& [known, format] : extensions)
    names.emplace_back(known);
  return list(names);
}

} // namespace signorini::scene
