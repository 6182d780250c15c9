// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh_shapes.h"
#include "mesh/gmsh_cells.h"
#include <fmt/format.h>
#include <gmsh.h>
#include <map>
#include <string>

namespace signorini::mesh {

namespace {

/// Name of an entity in a CAD file, without those of the assemblies that contain it; empty if it has none.
std::string shape_name(int dim, int tag) {
  std::string path;
  gmsh::model::getEntityName(dim, tag, path);
  const std::string name = path.substr(path.find_last_of('/') + 1); // npos + 1 is 0
  const bool made_up = name.starts_with("Open CASCADE STEP translator") || name == "COMPOUND";
  return made_up ? "" : name;
}

} // namespace

void group_shapes() {
  gmsh::vectorpair groups;
  gmsh::model::getPhysicalGroups(groups);
  const int body = gmsh::model::getDimension();
  if (!groups.empty() || body < 2)
    return;
  for (const int dim : {body, body - 1}) {
    gmsh::vectorpair entities;
    gmsh::model::getEntities(entities, dim);
    std::map<std::string, std::vector<int>> own;
    for (const auto& [entity_dim, tag] : entities) {
      std::vector<int> above, below;
      gmsh::model::getAdjacencies(dim, tag, above, below);
      if (dim == body)
        own["body"].push_back(tag);
      else if (above.size() == 1)
        own["boundary"].push_back(tag);
      const std::string name = shape_name(dim, tag);
      own[name.empty() ? fmt::format("{} {}", entity_kind(dim), tag) : name].push_back(tag);
    }
    for (const auto& [name, tags] : own)
      gmsh::model::addPhysicalGroup(dim, tags, -1, name);
  }
}

} // namespace signorini::mesh
