#include "mesh/mesh.h"
#include "base/collective.h"
#include "mesh/gmsh_model.h"
#include "scene/names.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/fem/CoordinateElement.h>
#include <dolfinx/io/xdmf_utils.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/MeshTags.h>
#include <dolfinx/mesh/utils.h>
#include <fmt/format.h>

namespace signorini::mesh {
namespace {

namespace stdex = MDSPAN_IMPL_STANDARD_NAMESPACE;

double bounding_diagonal(const RawMesh& raw) {
  std::array<double, 3> low{}, high{};
  for (int i = 0; i < 3; ++i)
    low[i] = high[i] = raw.points[i];
  for (std::size_t p = 0; p < raw.points.size(); ++p) {
    low[p % 3] = std::min(low[p % 3], raw.points[p]);
    high[p % 3] = std::max(high[p % 3], raw.points[p]);
  }
  return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

std::shared_ptr<dolfinx::mesh::Mesh<double>> distribute(MPI_Comm comm, const RawMesh& raw, int dim) {
  const auto type = dim == 2 ? dolfinx::mesh::CellType::triangle : dolfinx::mesh::CellType::tetrahedron;
  const dolfinx::fem::CoordinateElement<double> element(type, 1);
  std::vector<double> x;
  for (std::size_t p = 0; p < raw.points.size(); p += 3)
    x.insert(x.end(), &raw.points[p], &raw.points[p] + dim);
  const std::size_t nodes = raw.points.size() / 3;
  return std::make_shared<dolfinx::mesh::Mesh<double>>(
      dolfinx::mesh::create_mesh(comm, std::span<const std::int64_t>(raw.cells), element, x,
                                 {nodes, static_cast<std::size_t>(dim)}, dolfinx::mesh::GhostMode::none));
}

/// This rank's facets out of a list of facets on rank 0.
std::vector<std::int32_t> local_facets(const dolfinx::mesh::Mesh<double>& mesh,
                                       const std::vector<std::int64_t>& facets) {
  const auto topology = mesh.topology();
  const auto& geometry = mesh.geometry();
  const int tdim = topology->dim(), fdim = tdim - 1;
  const std::size_t count = facets.size() / tdim;
  const std::vector<std::int32_t> ones(count, 1);
  const auto [entities, values] = dolfinx::io::xdmf_utils::distribute_entity_data<std::int32_t>(
      *topology, geometry.input_global_indices(), geometry.index_map()->size_global(),
      geometry.cmap().create_dof_layout(), geometry.dofmap(), fdim,
      stdex::mdspan<const std::int64_t, stdex::dextents<std::size_t, 2>>(facets.data(), count, tdim), ones);
  std::vector<std::int32_t> local = dolfinx::mesh::entities_to_index(*topology, fdim, entities);
  std::ranges::sort(local);
  const auto [last, end] = std::ranges::unique(local);
  local.erase(last, end);
  std::erase(local, -1);
  return local;
}

} // namespace

Mesh::Mesh(MPI_Comm comm, const scene::Mesh& mesh) : comm_(comm), file_(mesh.file.string()) {
  RawMesh raw;
  on_root(comm, [&] { raw = read_gmsh(mesh); });
  if (rank(comm) == 0)
    dim_ = raw.dim, diameter_ = bounding_diagonal(raw);
  MPI_Bcast(&dim_, 1, MPI_INT, 0, comm);
  MPI_Bcast(&diameter_, 1, MPI_DOUBLE, 0, comm);
  mesh_ = distribute(comm, raw, dim_);
  const auto topology = mesh_->topology_mutable();
  cells_ = topology->index_map(dim_)->size_global();
  topology->create_entities(dim_ - 1);
  topology->create_connectivity(dim_ - 1, 0);
  topology->create_connectivity(dim_ - 1, dim_);
  topology->create_connectivity(dim_, dim_ - 1);

  std::string names, others;
  for (const auto& [name, facets] : raw.facets)
    names += name + '\n';
  for (const auto& [name, dim] : raw.other_groups)
    others += fmt::format("{}{}\n", dim, name);
  names = broadcast(comm, names);
  others = broadcast(comm, others);
  for (std::size_t start = 0, end; (end = names.find('\n', start)) != std::string::npos; start = end + 1) {
    const std::string name = names.substr(start, end - start);
    Group& group = groups_[name];
    group.facets = local_facets(*mesh_, raw.facets[name]);
    group.elements = static_cast<std::int64_t>(raw.facets[name].size()) / dim_;
    MPI_Bcast(&group.elements, 1, MPI_INT64_T, 0, comm);
  }
  for (std::size_t start = 0, end; (end = others.find('\n', start)) != std::string::npos; start = end + 1)
    other_groups_[others.substr(start + 1, end - start - 1)] = others[start] - '0';
}

const std::vector<std::int32_t>& Mesh::facets(const std::string& group, const std::string& key) const {
  const auto found = groups_.find(group);
  if (found != groups_.end() && found->second.elements > 0)
    return found->second.facets;
  const std::string boundary = dim_ == 2 ? "curve" : "surface";
  if (found != groups_.end())
    throw UserError(fmt::format("{}: the group \"{}\" of {} has no elements, allowed is a {} group with elements",
                                key, group, file_, boundary));
  std::vector<std::string> names;
  for (const auto& [name, g] : groups_)
    names.push_back(name);
  const std::string allowed = names.empty() ? "the file has none"
                                            : fmt::format("{} groups of the file: {}", boundary, scene::list(names));
  if (const auto other = other_groups_.find(group); other != other_groups_.end())
    throw UserError(fmt::format("{}: the group \"{}\" of {} has dimension {}, allowed are {}", key, group, file_,
                                other->second, allowed));
  const std::string near = scene::nearest(group, names);
  throw UserError(fmt::format("{}: {} has no {} group \"{}\" with elements{}; {}", key, file_, boundary, group,
                              near.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", near), allowed));
}

} // namespace signorini::mesh
