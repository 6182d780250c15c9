// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/sampler.h"
#include "base/collective.h"
#include "base/dolfinx_versions.h"
#include "mesh/simplex.h"
#include <algorithm>
#include <array>
#include <basix/quadrature.h>
#include <cmath>
#include <dolfinx/fem/CoordinateElement.h>
#include <dolfinx/fem/FiniteElement.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/geometry/utils.h>
#include <dolfinx/mesh/Mesh.h>
#include <limits>
#include <numbers>

namespace signorini::fem {
using mesh::Simplex;
using petsc::check;

namespace {

Simplex simplex(const dolfinx::mesh::Mesh<double>& mesh, std::int32_t cell) {
  return {mesh.topology()->dim(), dolfinx_versions::vertices(mesh.geometry(), cell)};
}

/// Entities in which points are located: cells or facets (by their dimension) that belong to this rank.
struct Entities {
  int dim;
  std::vector<std::int32_t> numbers;
};

/// Returns the entities of the group `on`, or the owned cells if `on` is absent.
Entities entities(const mesh::Mesh& mesh, const std::optional<std::string>& on, const std::string& key) {
  if (!on)
    return {mesh.dim(), mesh.owned_cells()};
  const int dim = mesh.group_dimension(*on, key);
  return {dim, dim == mesh.dim() ? mesh.cells(*on, key) : mesh.facets(*on, key)};
}

/// Entity found for a point: a cell that contains the point, else the nearest entity.
struct Near {
  double squared = std::numeric_limits<double>::infinity(); ///< squared distance of the point, m²
  std::int32_t entity = -1;                                 ///< −1 on ranks without entities
};

/// Finds for each point (n × 3) the nearest of `entities`, which are cells or facets by `dim`.
std::vector<Near> nearest(const dolfinx::mesh::Mesh<double>& mesh, int dim,
                          const std::vector<std::int32_t>& entities, const std::vector<double>& points) {
  std::vector<Near> found(points.size() / 3);
  if (entities.empty())
    return found;
  const auto tree = dolfinx_versions::bounding_boxes(mesh, dim, std::span(entities));
  const auto midpoints = dolfinx::geometry::create_midpoint_tree(mesh, dim, entities);
  std::vector<double> outside;
  std::vector<std::size_t> numbers;
  const auto look_outside = [&](std::size_t i) {
    numbers.push_back(i);
    outside.insert(outside.end(), &points[3 * i], &points[3 * i] + 3);
  };
  if (dim == mesh.topology()->dim()) {
    const auto candidates = dolfinx::geometry::compute_collisions<double>(tree, points);
    const auto holding = dolfinx::geometry::compute_colliding_cells<double>(mesh, candidates, points);
    for (std::size_t i = 0; i < found.size(); ++i)
      if (const auto links = holding.links(static_cast<std::int32_t>(i)); !links.empty())
        found[i] = {0, *std::ranges::min_element(links)};
      else
        look_outside(i);
  } else {
    for (std::size_t i = 0; i < found.size(); ++i)
      look_outside(i);
  }
  if (outside.empty())
    return found;
  const std::vector<std::int32_t> near =
      dolfinx::geometry::compute_closest_entity<double>(tree, midpoints, mesh, outside);
  const std::vector<double> distance = dolfinx::geometry::squared_distance<double>(mesh, dim, near, outside);
  for (std::size_t j = 0; j < numbers.size(); ++j)
    found[numbers[j]] = {distance[j], near[j]};
  return found;
}

/// Returns the first cell of a facet.
std::int32_t cell_of(const dolfinx::mesh::Topology& topology, std::int32_t facet) {
  return topology.connectivity(topology.dim() - 1, topology.dim())->links(facet).front();
}

/// Projects x (3) onto the plane of a facet of `cell`: onto the points where the barycentric coordinate of
/// the vertex opposite the facet is zero.
Simplex::Point onto_facet(const dolfinx::mesh::Mesh<double>& mesh, std::int32_t facet, std::int32_t cell,
                          const double* x) {
  const auto& topology = *mesh.topology();
  const int dim = topology.dim();
  const auto facets = topology.connectivity(dim, dim - 1)->links(cell);
  const int opposite = static_cast<int>(std::ranges::find(facets, facet) - facets.begin());
  const Simplex here = simplex(mesh, cell);
  const Simplex::Point xi = here.reference(x), g = here.gradient(opposite);
  const double coordinate = opposite > 0 ? xi[opposite - 1] : 1 - xi[0] - xi[1] - (dim == 3 ? xi[2] : 0),
               squared = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
  return {x[0] - coordinate / squared * g[0], x[1] - coordinate / squared * g[1],
          x[2] - coordinate / squared * g[2]};
}

/// Values of the element's scalar basis functions at the reference point ξ.
std::vector<double> basis(const dolfinx::fem::FiniteElement<double>& element, const std::array<double, 3>& xi,
                          int dim) {
  const auto [values, shape] = element.basix_element().tabulate(
      0, std::span(xi.data(), static_cast<std::size_t>(dim)), {1, static_cast<std::size_t>(dim)});
  return values;
}

} // namespace

Quadrature quadrature(const mesh::Mesh& mesh) {
  const auto& cells = *mesh.dolfinx();
  const int dim = mesh.dim();
  const int order = mesh.axisymmetric() ? 3 : 2; // of squares, with the radius in the weight
  const auto [x, w] = basix::quadrature::make_quadrature<double>(basix::quadrature::type::Default,
                                                                 dim == 2 ? basix::cell::type::triangle
                                                                          : basix::cell::type::tetrahedron,
                                                                 basix::polyset::type::standard, order);
  std::vector<std::array<double, 4>> rows; // x, y, z, weight
  for (std::int32_t c : mesh.owned_cells()) {
    const Simplex here = simplex(cells, c);
    for (std::size_t q = 0; q < w.size(); ++q) {
      const Simplex::Point point = here.point(&x[q * static_cast<std::size_t>(dim)]);
      const double depth = mesh.axisymmetric() ? 2 * std::numbers::pi * point[0] : 1;
      rows.push_back({point[0], point[1], point[2], depth * w[q] * here.abs_determinant()});
    }
  }
  rows = gather(mesh.comm(), rows);
  std::ranges::sort(rows);
  Quadrature result;
  for (const auto& row : rows) {
    result.points.insert(result.points.end(), row.begin(), row.begin() + 3);
    result.weights.push_back(row[3]);
  }
  return result;
}

Sampler::Sampler(const Space& space, const std::vector<double>& points, const std::optional<std::string>& on,
                 const std::string& key, bool cellwise)
    : dim_(space.dim()), comm_(space.comm()), count_(points.size() / 3) {
  const Entities among = entities(space.mesh(), on, key);
  const auto& mesh = *space.mesh().dolfinx();
  const bool facets = among.dim < dim_;
  const std::vector<Near> found = nearest(mesh, among.dim, among.numbers, points);
  // The rank with the nearest entity evaluates a point; of several ranks, the lowest.
  std::vector<double> least(count_);
  std::ranges::transform(found, least.begin(), &Near::squared);
  MPI_Allreduce(MPI_IN_PLACE, least.data(), static_cast<int>(count_), MPI_DOUBLE, MPI_MIN, comm_);
  distances_.resize(count_);
  std::ranges::transform(least, distances_.begin(), [](double square) { return std::sqrt(square); });
  std::vector<int> owner(count_);
  for (std::size_t i = 0; i < count_; ++i)
    owner[i] = found[i].entity >= 0 && found[i].squared <= least[i] ? rank(comm_) : ranks(comm_);
  MPI_Allreduce(MPI_IN_PLACE, owner.data(), static_cast<int>(count_), MPI_INT, MPI_MIN, comm_);
  for (std::size_t i = 0; i < count_; ++i)
    if (owner[i] == rank(comm_))
      mine_.push_back(i);

  const auto topology = mesh.topology();
  petsc::Matrix one;
  check(MatCreate(comm_, one.put()));
  const PetscInt columns_here = cellwise ? topology->index_map(dim_)->size_local() : space.layout().nodes();
  check(
      MatSetSizes(one, static_cast<PetscInt>(mine_.size()), columns_here, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(one, MATAIJ));
  check(MatSetUp(one));
  PetscInt row = 0;
  check(MatGetOwnershipRange(one, &row, nullptr));
  const auto dofmap = space.dolfinx()->dofmap();
  const auto element = space.dolfinx()->element();
  for (std::size_t i : mine_) {
    const std::int32_t entity = found[i].entity, cell = facets ? cell_of(*topology, entity) : entity;
    const std::vector<std::int32_t> own{cell};
    const auto nodes = cellwise ? std::span<const std::int32_t>(own) : dofmap->cell_dofs(cell);
    std::vector<std::int64_t> columns(nodes.size());
    (cellwise ? topology->index_map(dim_) : dofmap->index_map)->local_to_global(nodes, columns);
    const double* point = &points[3 * i];
    const Simplex::Point on_facet = facets ? onto_facet(mesh, entity, cell, point) : Simplex::Point{};
    const std::vector<double> phi =
        cellwise ? std::vector{1.0}
                 : basis(*element, simplex(mesh, cell).reference(facets ? on_facet.data() : point), dim_);
    for (std::size_t j = 0; j < columns.size(); ++j)
      check(MatSetValue(one, row, static_cast<PetscInt>(columns[j]), phi[j], INSERT_VALUES));
    ++row;
  }
  check(MatAssemblyBegin(one, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(one, MAT_FINAL_ASSEMBLY));
  check(MatCreateMAIJ(one, dim_, at_points_.put()));
  check(MatCreateVecs(at_points_, nullptr, values_.put()));
}

petsc::Vector Sampler::functional(std::size_t point, int component) const {
  petsc::Vector result;
  check(MatCreateVecs(at_points_, result.put(), nullptr));
  check(VecZeroEntries(values_));
  {
    const petsc::WriteArray values(values_);
    for (std::size_t j = 0; j < mine_.size(); ++j)
      if (mine_[j] == point)
        values[j * static_cast<std::size_t>(dim_) + static_cast<std::size_t>(component)] = 1;
  }
  check(MatMultTranspose(at_points_, values_, result));
  return result;
}

std::vector<double> Sampler::operator()(Vec y) const {
  check(MatMult(at_points_, y, values_));
  std::vector<double> all(count_ * static_cast<std::size_t>(dim_));
  {
    const petsc::ReadArray values(values_);
    const auto dim = static_cast<std::size_t>(dim_);
    for (std::size_t j = 0; j < mine_.size(); ++j)
      for (std::size_t c = 0; c < dim; ++c)
        all[mine_[j] * dim + c] = values[j * dim + c];
  }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, comm_);
  return all;
}

} // namespace signorini::fem
