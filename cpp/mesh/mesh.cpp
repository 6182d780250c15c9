// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mesh.h"
#include "base/collective.h"
#include "base/digest.h"
#include "base/dolfinx_versions.h"
#include "base/signals.h"
#include "base/text.h"
#include "mesh/distribution.h"
#include "mesh/gmsh_process.h"
#include "mesh/raw_mesh.h"
#include "mesh/refinement.h"
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/MeshTags.h>
#include <dolfinx/mesh/utils.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numeric>
#include <utility>

namespace signorini::mesh {
namespace {

namespace stdex = MDSPAN_IMPL_STANDARD_NAMESPACE;

std::array<double, 3> bounding_box(const RawMesh& raw) {
  std::array<double, 3> low{}, high{};
  for (int i = 0; i < 3; ++i)
    low[i] = high[i] = raw.points[i];
  for (std::size_t p = 0; p < raw.points.size(); ++p) {
    low[p % 3] = std::min(low[p % 3], raw.points[p]);
    high[p % 3] = std::max(high[p % 3], raw.points[p]);
  }
  return {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
}

/// Takes a mesh as the half section of a body of revolution: sets the radius x of nodes on the axis to 0.
/// Throws UserError if a node has a negative radius.
void take_as_half_section(RawMesh& raw) {
  constexpr double on_axis = 1e-9; // of the longest side; nodes that gmsh puts on the axis are 1e-15 off
  const double tolerance = on_axis * std::ranges::max(bounding_box(raw));
  for (std::size_t p = 0; raw.dim == 2 && p < raw.points.size(); p += 3)
    if (raw.points[p] < -tolerance)
      throw UserError(fmt::format("mesh.model: found \"axisymmetric\" with a node at x = {:.6g} m; x is the "
                                  "radius. Move the body to x >= 0, with the axis at x = 0",
                                  raw.points[p]));
    else if (std::abs(raw.points[p]) <= tolerance)
      raw.points[p] = 0;
}

/// Distributes facets from a list on rank 0 (facets × dim, nodes of the file). Returns the local indices of
/// those that this rank has, ascending. Collective.
std::vector<std::int32_t> local_facets(const dolfinx::mesh::Mesh<double>& mesh,
                                       const std::vector<std::int64_t>& facets) {
  const auto topology = mesh.topology();
  const int tdim = topology->dim(), fdim = tdim - 1;
  const std::size_t count = facets.size() / tdim;
  const std::vector<std::int32_t> ones(count, 1);
  const auto [entities, values] = dolfinx_versions::distribute_entity_data(
      mesh, fdim,
      stdex::mdspan<const std::int64_t, stdex::dextents<std::size_t, 2>>(facets.data(), count, tdim), ones);
  std::vector<std::int32_t> local = dolfinx::mesh::entities_to_index(*topology, fdim, entities);
  std::ranges::sort(local);
  const auto [last, end] = std::ranges::unique(local);
  local.erase(last, end);
  std::erase(local, -1);
  return local;
}

/// Local indices, ascending, of the cells that this rank owns among `ranges` of the file's cells (ranges ×
/// 2).
std::vector<std::int32_t> owned_of(const dolfinx::mesh::Topology& topology,
                                   const std::vector<std::int64_t>& ranges) {
  const std::vector<std::int64_t>& row = topology.original_cell_index.front();
  std::vector<std::int32_t> cells;
  for (std::int32_t cell = 0; cell < topology.index_map(topology.dim())->size_local(); ++cell)
    if ((std::ranges::upper_bound(ranges, row[cell]) - ranges.begin()) % 2 == 1) // ranges ascend
      cells.push_back(cell);
  return cells;
}

/// Writes a mesh to a file, reads the file again and returns that mesh, whose cells are in the order of the
/// file.
RawMesh kept(const RawMesh& raw, scene::Mesh scene, const std::filesystem::path& file) {
  write_msh(raw, file, scene.unit);
  scene.file = file;
  scene.split = false; // the simplices were written
  RawMesh again = read_gmsh(scene);
  again.unusable = raw.unusable;
  again.notes = raw.notes;
  return again;
}

} // namespace

Mesh::Mesh(MPI_Comm comm, const scene::Mesh& mesh, const Meshing& meshing)
    : comm_(comm), file_(mesh.file.string()), model_(mesh.model.value_or(scene::PlaneModel::plane_strain)) {
  RawMesh raw;
  on_root(comm, [&] {
    try {
      raw = read_gmsh(mesh, meshing);
      if (mesh.meshed() && !meshing.keep.empty())
        raw = kept(meshing.sizes ? refined(std::move(raw), *meshing.sizes) : raw, mesh, meshing.keep);
      if (axisymmetric())
        take_as_half_section(raw);
    } catch (const Interrupted&) { // all ranks throw it below
    }
  });
  if (stop_requested(comm))
    throw Interrupted();
  notes_ = std::exchange(raw.notes, {}); // not part of the mesh's digest
  if (rank(comm) == 0)
    dim_ = raw.dim, extent_ = bounding_box(raw), digest_ = Digest().add(packed(raw)).text();
  MPI_Bcast(&dim_, 1, MPI_INT, 0, comm);
  MPI_Bcast(extent_.data(), 3, MPI_DOUBLE, 0, comm);
  mesh_ = distributed(comm, raw, dim_);
  const auto topology = mesh_->topology_mutable();
  cells_ = topology->index_map(dim_)->size_global();
  topology->create_entities(dim_ - 1);
  topology->create_connectivity(dim_ - 1, 0);
  topology->create_connectivity(dim_ - 1, dim_);
  topology->create_connectivity(dim_, dim_ - 1);

  RawMesh groups; // the file's groups, on every rank
  groups.facets = raw.facets;
  groups.parts = raw.parts;
  groups.other_groups = raw.other_groups;
  groups.unusable = raw.unusable;
  groups = unpacked(broadcast(comm, packed(groups)));
  for (const auto& [name, dim] : groups.other_groups)
    groups_[dim][name].empty = false;
  for (const auto& [name, facets] : groups.facets) // which rank 0 distributes
    groups_[dim_ - 1][name] = {.entities = local_facets(*mesh_, raw.facets[name]), .empty = facets.empty()};
  for (const auto& [name, ranges] : groups.parts)
    groups_[dim_][name] = {.entities = owned_of(*topology, ranges), .empty = ranges.empty()};
  for (const auto& [dim, unusable] : groups.unusable)
    for (const auto& [name, why] : unusable)
      groups_[dim][name].unusable = why;
}

int Mesh::find(const std::string& group, const std::string& key, const std::vector<int>& dims) const {
  std::vector<int> found;
  std::vector<std::string> names, kinds, lists;
  std::string unusable;
  bool empty = false;
  for (int dim : dims) {
    constexpr std::array words{"point", "curve", "surface", "volume"};
    kinds.emplace_back(words.at(dim));
    std::vector<std::string> own;
    for (const auto& [name, g] : groups_.at(dim)) {
      if (!g.unusable.empty()) {
        if (name == group)
          unusable = g.unusable;
        continue;
      }
      own.push_back(name);
      if (name == group)
        g.empty ? void(empty = true) : found.push_back(dim);
    }
    names.insert(names.end(), own.begin(), own.end());
    if (!own.empty())
      lists.push_back(fmt::format("{} groups of the file: {}", kinds.back(), list(own)));
  }
  if (found.size() == 1)
    return found.front();
  const std::string kind = fmt::format("{} group", fmt::join(kinds, " or "));
  if (found.size() > 1)
    throw UserError(fmt::format("{}: {} has a {} group and a {} group \"{}\"; rename one of them", key, file_,
                                kinds[0], kinds[1], group));
  if (!unusable.empty())
    throw UserError(fmt::format("{}: the group \"{}\" of {} {}", key, group, file_, unusable));
  if (empty)
    throw UserError(fmt::format("{}: the group \"{}\" of {} has no elements; choose a {} with elements", key,
                                group, file_, kind));
  const std::string allowed = lists.empty() ? "the file has none" : fmt::format("{}", fmt::join(lists, "; "));
  for (std::size_t dim = 0; dim < groups_.size(); ++dim)
    if (groups_[dim].contains(group))
      throw UserError(
          fmt::format("{}: the group \"{}\" of {} has dimension {}; {}", key, group, file_, dim, allowed));
  throw UserError(fmt::format("{}: {} has no {} \"{}\" with elements{}; {}", key, file_, kind, group,
                              suggestion(group, names), allowed));
}

std::vector<std::int32_t> Mesh::owned_cells() const {
  std::vector<std::int32_t> cells(static_cast<std::size_t>(mesh_->topology()->index_map(dim_)->size_local()));
  std::iota(cells.begin(), cells.end(), 0);
  return cells;
}

const std::vector<std::int32_t>& Mesh::facets(const std::string& group, const std::string& key) const {
  return groups_.at(find(group, key, {dim_ - 1})).at(group).entities;
}

const std::vector<std::int32_t>& Mesh::cells(const std::string& group, const std::string& key) const {
  return groups_.at(find(group, key, {dim_})).at(group).entities;
}

std::vector<std::string> Mesh::cell_groups() const {
  std::vector<std::string> names;
  for (const auto& [name, group] : groups_[static_cast<std::size_t>(dim_)])
    if (!group.empty && group.unusable.empty())
      names.push_back(name);
  return names;
}

int Mesh::group_dimension(const std::string& group, const std::string& key) const {
  return find(group, key, {dim_, dim_ - 1});
}

} // namespace signorini::mesh
