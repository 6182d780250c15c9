// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/material_regions.h"
#include "base/collective.h"
#include "base/text.h"
#include "scene/spelling.h"
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/utils.h>
#include <fmt/format.h>

namespace signorini::fem {
namespace {

/// A cell's midpoint for messages.
std::string place(const mesh::Mesh& mesh, std::int32_t cell) {
  const std::vector<double> x =
      dolfinx::mesh::compute_midpoints(*mesh.dolfinx(), mesh.dim(), std::vector{cell});
  return point_text(x.data(), mesh.dim());
}

/// Throws UserError unless every cell of this rank is in exactly one part.
void require_one_material(const mesh::Mesh& mesh, const std::vector<Part>& parts) {
  constexpr std::size_t none = -1;
  std::vector<std::size_t> part_of(mesh.owned_cells().size(), none);
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (std::int32_t cell : parts[p].cells) {
      std::size_t& part = part_of[static_cast<std::size_t>(cell)];
      if (part != none)
        throw UserError(
            fmt::format("material: the cell at {} is in the groups \"{}\" and \"{}\" of two materials, "
                        "allowed is one material for every cell",
                        place(mesh, cell), *parts[part].material.on, *parts[p].material.on));
      part = p;
    }
  const auto found = std::ranges::find(part_of, none);
  if (found == part_of.end())
    return;
  std::vector<std::string> groups;
  for (const Part& part : parts)
    groups.push_back(*part.material.on);
  throw UserError(
      fmt::format("material: the cell at {} is in no group of a material ({}), allowed is one material for "
                  "every cell",
                  place(mesh, static_cast<std::int32_t>(found - part_of.begin())), scene::list(groups)));
}

} // namespace

std::vector<Part> parts(const mesh::Mesh& mesh, const std::vector<scene::Material>& materials) {
  std::vector<Part> parts;
  for (std::size_t i = 0; i < materials.size(); ++i)
    parts.push_back({materials[i], materials[i].on
                                       ? mesh.cells(*materials[i].on, fmt::format("material[{}].on", i))
                                       : mesh.owned_cells()});
  on_all_ranks(mesh.comm(), [&] { require_one_material(mesh, parts); });
  return parts;
}

} // namespace signorini::fem
