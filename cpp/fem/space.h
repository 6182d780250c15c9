// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "mesh/mesh.h"
#include "scene/expression.h"
#include <array>
#include <concepts>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace dolfinx::fem {
template <std::floating_point T>
class FunctionSpace;
}

namespace signorini::fem {

/// Node outside of the mesh, for example for the translation or the rotation of a rigid body. Only
/// constraints couple it to other nodes: the forms m, b and a are diagonal for its dofs (docs/method.md
/// section 1).
struct VirtualNode {
  std::array<double, 3> mass{};      ///< diagonal of form m by component: kg, or kg m² for a rotation
  std::array<double, 3> damping{};   ///< diagonal of form b: N s/m, or N m s for a rotation
  std::array<double, 3> stiffness{}; ///< diagonal of form a: N/m, or N m for a rotation
  std::array<bool, 3> clamped{};     ///< components that are fixed to zero
};

/// Numbering of a space's unknowns: each rank has its nodes of the mesh, followed on the last rank by the
/// virtual nodes. Vectors have dim values per node, node by node.
class Layout {
public:
  /// `mesh_nodes`: number of the mesh's nodes that this rank owns; `virtual_nodes`: all virtual nodes, the
  /// same on every rank. Collective.
  Layout(MPI_Comm comm, int dim, int mesh_nodes, std::vector<VirtualNode> virtual_nodes);

  [[nodiscard]] int dim() const { return dim_; }
  /// Number of the mesh's nodes that this rank owns.
  [[nodiscard]] int mesh_nodes() const { return mesh_nodes_; }
  /// Number of the mesh's dofs that this rank owns; those of its virtual nodes follow.
  [[nodiscard]] std::size_t mesh_dofs() const {
    return static_cast<std::size_t>(mesh_nodes_) * static_cast<std::size_t>(dim_);
  }
  /// Number of nodes that this rank owns, virtual nodes included.
  [[nodiscard]] int nodes() const {
    return mesh_nodes_ + (owns_virtual_nodes_ ? static_cast<int>(virtual_.size()) : 0);
  }
  /// Global number of this rank's first dof.
  [[nodiscard]] PetscInt first_dof() const { return first_dof_; }
  /// Number of dofs on all ranks.
  [[nodiscard]] PetscInt dofs() const { return dofs_; }

  [[nodiscard]] const std::vector<VirtualNode>& virtual_nodes() const { return virtual_; }
  /// Global number of the first dof of a virtual node.
  [[nodiscard]] PetscInt first_dof_of_virtual(std::size_t node) const {
    return dofs_ - static_cast<PetscInt>(virtual_.size() - node) * dim_;
  }
  /// Whether this rank owns the virtual nodes.
  [[nodiscard]] bool owns_virtual_nodes() const { return owns_virtual_nodes_; }

  /// Creates a zero vector. Collective.
  [[nodiscard]] petsc::Vector vector() const;

  /// Adds rows for the dofs of the virtual nodes to a matrix whose rows are the mesh's dofs. A square matrix
  /// gets the same columns too, with `diagonal` (virtual nodes × dim; zero if empty) as diagonal entries.
  /// Returns `matrix` unchanged if there are no virtual nodes. Collective.
  [[nodiscard]] petsc::Matrix extended(petsc::Matrix matrix, std::span<const double> diagonal = {}) const;
  /// Creates the diagonal matrix of V with `diagonal` (virtual nodes × dim) at the dofs of the virtual nodes
  /// and zero elsewhere. Collective.
  [[nodiscard]] petsc::Matrix diagonal(std::span<const double> diagonal) const;

private:
  MPI_Comm comm_;
  int dim_, mesh_nodes_;
  std::vector<VirtualNode> virtual_;
  bool owns_virtual_nodes_;
  PetscInt first_dof_ = 0, dofs_ = 0;
};

/// The space V: continuous vector-valued Lagrange functions of degree 1 or 2 on the mesh, without boundary
/// conditions, together with the unknowns of virtual nodes. A vector of V contains the values at the nodes,
/// node by node, in the order of layout(). In space each rank numbers its nodes by a breadth-first search, in
/// the plane dolfinx does.
class Space {
public:
  /// Sets up the space. `mesh` must outlive it. Collective.
  Space(const mesh::Mesh& mesh, int degree, std::vector<VirtualNode> virtual_nodes = {});
  /// Sets up a space with the functions of `space` and other virtual nodes. Collective.
  Space(const Space& space, std::vector<VirtualNode> virtual_nodes);

  [[nodiscard]] int dim() const { return mesh_->dim(); }
  [[nodiscard]] int degree() const { return degree_; }
  [[nodiscard]] const mesh::Mesh& mesh() const { return *mesh_; }
  [[nodiscard]] MPI_Comm comm() const { return mesh_->comm(); }

  [[nodiscard]] const Layout& layout() const { return layout_; }
  /// Number of the mesh's nodes that this rank owns.
  [[nodiscard]] int owned_nodes() const { return layout_.mesh_nodes(); }
  /// Global number of this rank's first dof.
  [[nodiscard]] PetscInt first_dof() const { return layout_.first_dof(); }
  /// Number of dofs on all ranks.
  [[nodiscard]] PetscInt dofs() const { return layout_.dofs(); }
  /// Coordinates of the mesh's nodes that this rank owns, (owned_nodes × 3), m.
  [[nodiscard]] const std::vector<double>& points() const { return points_; }

  /// Whether a translation along a component (0, 1, 2) is a rigid motion: true except along the radius of a
  /// body of revolution. Forces and momenta have resultants along these components only.
  [[nodiscard]] bool translates(std::size_t component) const {
    return component > 0 || !mesh_->axisymmetric();
  }
  /// Whether an owned node (local number) is on the axis of a body of revolution, where the radial
  /// displacement is zero.
  [[nodiscard]] bool on_axis(int node) const {
    return on_axis_of_revolution(points_[3 * static_cast<std::size_t>(node)]);
  }
  /// Whether points with the coordinate x are on the axis of a body of revolution.
  [[nodiscard]] bool on_axis_of_revolution(double x) const { return mesh_->axisymmetric() && x == 0; }

  /// Global numbers of this rank's nodes of the mesh, first the owned ones, then the ghosts.
  [[nodiscard]] std::vector<std::int64_t> global_nodes() const;

  /// Creates a zero vector of V. Collective.
  [[nodiscard]] petsc::Vector vector() const { return layout_.vector(); }

  /// Local numbers, ascending, of the owned nodes on a boundary group. `with_area`: without the group's
  /// facets on the axis of a body of revolution. Collective. Throws UserError naming `key`, as
  /// mesh::Mesh::facets does.
  [[nodiscard]] std::vector<int> nodes_on(const std::string& group, const std::string& key,
                                          bool with_area = false) const;

  /// Sets `out` to the nodal values of a field at time t, s; entries of virtual nodes remain unchanged.
  /// Collective. Throws UserError on every rank if a value is not finite.
  void interpolate(const scene::Field& field, double t, Vec out) const;

  /// Midpoints of the cells that this rank owns, (cells × 3), m.
  [[nodiscard]] std::vector<double> midpoints() const;

  [[nodiscard]] std::shared_ptr<dolfinx::fem::FunctionSpace<double>> dolfinx() const { return V_; }

private:
  const mesh::Mesh* mesh_;
  int degree_;
  std::shared_ptr<dolfinx::fem::FunctionSpace<double>> V_;
  Layout layout_;
  std::vector<double> points_;
};

/// Shape of a function's value: empty for a scalar, (dim) for a vector, (3, 3) for a tensor.
using Shape = std::vector<std::size_t>;

/// Creates the space of functions that are constant on each cell, with vector values or with values of the
/// given shape. Collective.
std::shared_ptr<dolfinx::fem::FunctionSpace<double>> cellwise(const mesh::Mesh& mesh);
std::shared_ptr<dolfinx::fem::FunctionSpace<double>> cellwise(const mesh::Mesh& mesh, const Shape& shape);

/// Matrix that embeds functions of degree 1 (columns) into those of degree 2 (rows) on the same mesh. The row
/// of a vertex has the entry 1. The row of an edge's midpoint has the entries ½ and ½, in the columns of the
/// edge's ends. One component is stored for all (MAIJ). Collective.
petsc::Matrix embedding(const Space& linear, const Space& quadratic);

} // namespace signorini::fem
