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
#include <dolfinx/graph/AdjacencyList.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/utils.h>
#include <functional>
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

/// Wrappers for calls that differ between dolfinx 0.9, 0.10 and 0.11. They are templates because only in a
/// template does the compiler skip the branch of `if constexpr` that the installed version lacks.
namespace signorini::dolfinx_versions {

/// Returns the coordinate element of the geometry; all cells of a mesh have the same one.
template <class Geometry>
const auto& coordinate_element(const Geometry& geometry) {
  if constexpr (requires { geometry.cmap(); }) // until 0.10
    return geometry.cmap();
  else
    return geometry.cmaps().front();
}

/// Returns the geometry's node numbers of each cell (cells × nodes per cell).
template <class Geometry>
auto cell_nodes(const Geometry& geometry) {
  if constexpr (requires { geometry.cmap(); }) // until 0.10
    return geometry.dofmap();
  else
    return geometry.dofmaps().front();
}

/// Returns a function that maps the number i of a vertex of the straight cell `cell` to the address of the
/// vertex's three coordinates, m.
template <class Geometry>
auto vertices(const Geometry& geometry, std::int32_t cell) {
  return [nodes = cell_nodes(geometry), x = geometry.x(), cell](int i) {
    return &x[3 *
              static_cast<std::size_t>(nodes(static_cast<std::size_t>(cell), static_cast<std::size_t>(i)))];
  };
}

/// Returns the entries of a dolfinx vector as a writable span.
template <class Vector>
auto entries(Vector& vector) {
  if constexpr (std::is_assignable_v<decltype(*vector.array().begin()), typename Vector::value_type>) // 0.11
    return std::span(vector.array());
  else
    return vector.mutable_array();
}

/// Distributes values of facets or cells (entities of dimension `dim`). `entities`: nodes of each entity
/// (entities × nodes), by their numbers in the input; entities and `values` may be listed on any rank.
/// Returns the entities that this rank has, and their values. Collective.
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

/// Whether dolfinx's create_mesh() has an argument for the number of cells that share a facet (from dolfinx
/// 0.11).
template <class Links>
constexpr bool wants_links =
    requires(Links links) { dolfinx::mesh::create_cell_partitioner(dolfinx::mesh::GhostMode::none, links); };

/// Creates a mesh without ghost cells on `comm`. If `divides`, the ranks of `dividing` partition the graph of
/// the cells among the ranks of `comm`; otherwise each cell stays on the rank that passes it. `shape`: rows
/// and columns of the coordinates `x`. Collective.
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

/// Returns the geometry's nodes at the corners of `entities` of dimension `dim` (entities × corners), local
/// indices.
template <std::floating_point T>
std::vector<std::int32_t> corners(const dolfinx::mesh::Mesh<T>& mesh, int dim,
                                  std::span<const std::int32_t> entities) {
  auto found = dolfinx::mesh::entities_to_geometry(mesh, dim, entities, false);
  if constexpr (requires { found.first; }) // from 0.10 on
    return std::move(found.first);
  else
    return found;
}

/// Function that returns the new number of each node of the graph of a rank's nodes.
using NodeOrder = std::function<std::vector<int>(const dolfinx::graph::AdjacencyList<std::int32_t>&)>;

/// Creates the space of functions of an element, with values of the given shape (empty for scalars). `order`:
/// numbers the nodes of each rank; null for the order of dolfinx. Collective.
template <std::floating_point T, class Element>
auto create_functionspace(std::shared_ptr<dolfinx::mesh::Mesh<T>> mesh, const Element& element,
                          const std::vector<std::size_t>& shape, const NodeOrder& order) {
  if constexpr (requires { dolfinx::fem::create_functionspace(mesh, element, shape, order); }) // 0.9
    return dolfinx::fem::create_functionspace(mesh, element, shape, order);
  else
    return dolfinx::fem::create_functionspace<T>(
        mesh,
        std::make_shared<const dolfinx::fem::FiniteElement<T>>(element, shape.empty() ? std::nullopt
                                                                                      : std::optional(shape)),
        order);
}

/// Creates an expression from its generated code; `functions` and `constants` are passed by their names in
/// UFL.
template <std::floating_point T>
auto create_expression(
    const ufcx_expression& code,
    const std::map<std::string, std::shared_ptr<const dolfinx::fem::Function<T>>>& functions,
    const std::map<std::string, std::shared_ptr<const dolfinx::fem::Constant<T>>>& constants) {
  using dolfinx::fem::create_expression;
  if constexpr (requires { create_expression<T, T>(code, functions, constants); }) // until 0.10
    return create_expression<T, T>(code, functions, constants);
  else // this version also takes the entities of other meshes: none
    return create_expression<T, T>(code, functions, constants, {});
}

/// Returns the tree of the bounding boxes of `entities` of dimension `dim` (local indices) of a mesh.
template <std::floating_point T>
auto bounding_boxes(const dolfinx::mesh::Mesh<T>& mesh, int dim, std::span<const std::int32_t> entities) {
  using Tree = dolfinx::geometry::BoundingBoxTree<T>;
  if constexpr (std::is_constructible_v<Tree, decltype(mesh), int, std::span<const std::int32_t>>) // 0.9
    return Tree(mesh, dim, entities);
  else
    return Tree(mesh, dim, 0, entities);
}

} // namespace signorini::dolfinx_versions
