// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <array>
#include <concepts>
#include <cstdint>
#include <dolfinx/fem/Constant.h>
#include <dolfinx/fem/CoordinateElement.h>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/geometry/BoundingBoxTree.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/utils.h>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>
#if __has_include(<dolfinx/io/utils.h>) // 0.10
#include <dolfinx/io/utils.h>
#else
#include <dolfinx/io/xdmf_utils.h>
#endif

/// Calls that differ between dolfinx 0.9, 0.10 and 0.11. They are templates: a branch of
/// `if constexpr` that a version lacks must not be compiled.
namespace signorini::dolfinx_versions {

/// The one coordinate element of all cells.
template <class Geometry>
const auto& coordinate_element(const Geometry& geometry) {
  if constexpr (requires { geometry.cmap(); }) // until 0.10
    return geometry.cmap();
  else
    return geometry.cmaps().front();
}

/// The nodes of the geometry of each cell (cells × nodes).
template <class Geometry>
auto cell_nodes(const Geometry& geometry) {
  if constexpr (requires { geometry.cmap(); }) // until 0.10
    return geometry.dofmap();
  else
    return geometry.dofmaps().front();
}

/// Returns the vertices of a straight cell as a function of their number: the address of three coordinates.
template <class Geometry>
auto vertices(const Geometry& geometry, std::int32_t cell) {
  return [nodes = cell_nodes(geometry), x = geometry.x(), cell](int i) {
    return &x[3 *
              static_cast<std::size_t>(nodes(static_cast<std::size_t>(cell), static_cast<std::size_t>(i)))];
  };
}

/// The entries of a vector, writable.
template <class Vector>
auto entries(Vector& vector) {
  if constexpr (std::is_assignable_v<decltype(*vector.array().begin()), typename Vector::value_type>) // 0.11
    return std::span(vector.array());
  else
    return vector.mutable_array();
}

/// Returns the facets or cells of this rank and their values, from lists on any rank (entities × nodes of the
/// file). Collective.
template <class Mesh, class Entities>
auto distribute_entity_data(const Mesh& mesh, int dim, const Entities& entities,
                            std::span<const std::int32_t> values) {
#if __has_include(<dolfinx/io/utils.h>)
  using dolfinx::io::distribute_entity_data;
#else
  using dolfinx::io::xdmf_utils::distribute_entity_data;
#endif
  const auto& geometry = mesh.geometry();
  return distribute_entity_data<std::int32_t>(
      *mesh.topology(), geometry.input_global_indices(), geometry.index_map()->size_global(),
      coordinate_element(geometry).create_dof_layout(), cell_nodes(geometry), dim, entities, values);
}

/// Whether create_mesh has an argument for the number of cells that share a facet (FEniCSx 0.11).
template <class Links>
constexpr bool wants_links =
    requires(Links links) { dolfinx::mesh::create_cell_partitioner(dolfinx::mesh::GhostMode::none, links); };

/// Creates a mesh without ghost cells, divided among the ranks of `comm` by a graph that the ranks of
/// `dividing` partition. Without `divides` cells stay where they are given. Collective.
template <std::floating_point T>
dolfinx::mesh::Mesh<T> create_mesh(MPI_Comm comm, MPI_Comm dividing, std::span<const std::int64_t> cells,
                                   const dolfinx::fem::CoordinateElement<T>& element, const std::vector<T>& x,
                                   std::array<std::size_t, 2> shape, bool divides) {
  using Links = std::optional<std::int32_t>;
  const auto make = [&](auto... links) {
    dolfinx::mesh::CellPartitionFunction divide;
    if (divides)
      divide = dolfinx::mesh::create_cell_partitioner(dolfinx::mesh::GhostMode::none, links...);
    return dolfinx::mesh::create_mesh(comm, dividing, cells, element, comm, x, shape, divide, links...);
  };
  if constexpr (wants_links<Links>)
    return make(Links(2));
  else
    return make();
}

/// Nodes of the geometry at the corners of these entities (entities × corners), local indices.
template <std::floating_point T>
std::vector<std::int32_t> corners(const dolfinx::mesh::Mesh<T>& mesh, int dim,
                                  std::span<const std::int32_t> entities) {
  auto found = dolfinx::mesh::entities_to_geometry(mesh, dim, entities, false);
  if constexpr (requires { found.first; }) // from 0.10 on
    return std::move(found.first);
  else
    return found;
}

/// A space of functions of this shape. Collective.
template <std::floating_point T, class Element>
auto create_functionspace(std::shared_ptr<dolfinx::mesh::Mesh<T>> mesh, const Element& element,
                          const std::vector<std::size_t>& shape) {
  if constexpr (requires { dolfinx::fem::create_functionspace(mesh, element, shape); }) // 0.9
    return dolfinx::fem::create_functionspace(mesh, element, shape);
  else
    return dolfinx::fem::create_functionspace<T>(
        mesh, std::make_shared<const dolfinx::fem::FiniteElement<T>>(
                  element, shape.empty() ? std::nullopt : std::optional(shape)));
}

/// A compiled expression of these functions and constants, by their names in UFL.
template <std::floating_point T>
auto create_expression(
    const ufcx_expression& code,
    const std::map<std::string, std::shared_ptr<const dolfinx::fem::Function<T>>>& functions,
    const std::map<std::string, std::shared_ptr<const dolfinx::fem::Constant<T>>>& constants) {
  using dolfinx::fem::create_expression;
  if constexpr (requires { create_expression<T, T>(code, functions, constants); }) // until 0.10
    return create_expression<T, T>(code, functions, constants);
  else // no other mesh's entities
    return create_expression<T, T>(code, functions, constants, {});
}

/// The boxes of these entities of a mesh.
template <std::floating_point T>
auto bounding_boxes(const dolfinx::mesh::Mesh<T>& mesh, int dim, std::span<const std::int32_t> entities) {
  using Tree = dolfinx::geometry::BoundingBoxTree<T>;
  if constexpr (std::is_constructible_v<Tree, decltype(mesh), int, std::span<const std::int32_t>>) // 0.9
    return Tree(mesh, dim, entities);
  else
    return Tree(mesh, dim, 0, entities);
}

} // namespace signorini::dolfinx_versions
