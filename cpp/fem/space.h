// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "mesh/mesh.h"
#include "scene/expression.h"
#include <array>
#include <concepts>
#include <memory>
#include <span>
#include <vector>

namespace dolfinx::fem {
template <std::floating_point T>
class FunctionSpace;
}

namespace signorini::fem {

/// A node that is in no cell of the mesh, such as the translation or the rotation of a rigid body. It is
/// coupled to others by constraints alone: the forms m, b and a are diagonal there (docs/method.md
/// section 1).
struct VirtualNode {
  std::array<double, 3> mass{};      ///< form m by component: kg, or kg m² for a rotation
  std::array<double, 3> damping{};   ///< form b: N s/m, or N m s
  std::array<double, 3> stiffness{}; ///< form a: N/m, or N m
  std::array<bool, 3> clamped{};     ///< components that are zero
};

/// Layout of a space's unknowns: first the mesh's nodes of each rank, then, on the last rank, the virtual
/// nodes. Vectors have nodes × dim values, node by node.
class Layout {
public:
  /// `mesh_nodes`: number of the mesh's nodes that this rank owns; `virtual_nodes`: the same on every rank.
  /// Collective.
  Layout(MPI_Comm comm, int dim, int mesh_nodes, std::vector<VirtualNode> virtual_nodes);

  [[nodiscard]] int dim() const { return dim_; }
  /// Number of the mesh's nodes that this rank owns.
  [[nodiscard]] int mesh_nodes() const { return mesh_nodes_; }
  /// Number of nodes that this rank owns.
  [[nodiscard]] int nodes() const { return mesh_nodes_ + (here_ ? static_cast<int>(virtual_.size()) : 0); }
  /// Global number of this rank's first dof.
  [[nodiscard]] PetscInt first_dof() const { return first_dof_; }
  /// Number of dofs on all ranks.
  [[nodiscard]] PetscInt dofs() const { return dofs_; }

  [[nodiscard]] const std::vector<VirtualNode>& virtual_nodes() const { return virtual_; }
  /// Whether this rank owns the virtual nodes.
  [[nodiscard]] bool here() const { return here_; }

  /// A zero vector. Collective.
  [[nodiscard]] petsc::Vector vector() const;

  /// Extends a matrix over the mesh's dofs, or from other columns to these, by rows for the virtual ones. A
  /// square matrix gets columns too, with `diagonal` (virtual nodes × dim) there. Returns `matrix` itself if
  /// there are no virtual nodes. Collective.
  [[nodiscard]] petsc::Matrix extended(petsc::Matrix matrix, std::span<const double> diagonal = {}) const;

private:
  MPI_Comm comm_;
  int dim_, mesh_nodes_;
  std::vector<VirtualNode> virtual_;
  bool here_;
  PetscInt first_dof_ = 0, dofs_ = 0;
};

/// V: continuous vector Lagrange functions of degree 1 or 2 on the mesh, without boundary conditions, and the
/// unknowns of virtual nodes. Vectors of V contain the values at the owned nodes, node by node, in the order
/// of layout().
class Space {
public:
  /// Collective. `mesh` must outlive the space.
  Space(const mesh::Mesh& mesh, int degree, std::vector<VirtualNode> virtual_nodes = {});

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

  /// A zero vector of V. Collective.
  [[nodiscard]] petsc::Vector vector() const { return layout_.vector(); }

  /// Owned nodes on a boundary group, ascending local numbers. Collective. Throws UserError naming
  /// `key`, as mesh::Mesh::facets does.
  [[nodiscard]] std::vector<int> nodes_on(const std::string& group, const std::string& key) const;

  /// Nodal interpolation of a field at time t, s; leaves virtual nodes as they are. Collective. Throws
  /// UserError on every rank if a value is not finite.
  void interpolate(const scene::Field& field, double t, Vec out) const;

  /// Midpoints of the owned cells, (cells × 3), m.
  [[nodiscard]] std::vector<double> midpoints() const;

  [[nodiscard]] std::shared_ptr<dolfinx::fem::FunctionSpace<double>> dolfinx() const { return V_; }

private:
  const mesh::Mesh* mesh_;
  int degree_;
  std::shared_ptr<dolfinx::fem::FunctionSpace<double>> V_;
  Layout layout_;
  std::vector<double> points_;
};

/// Numbers of components along each axis of a value: empty for a scalar, (dim) for a vector.
using Shape = std::vector<std::size_t>;

/// The space of functions that are constant on each cell, of vectors or of another shape. Collective.
std::shared_ptr<dolfinx::fem::FunctionSpace<double>> cellwise(const mesh::Mesh& mesh);
std::shared_ptr<dolfinx::fem::FunctionSpace<double>> cellwise(const mesh::Mesh& mesh, const Shape& shape);

/// Matrix of the embedding of functions of degree 1 (columns) into those of degree 2 (rows) on the same mesh:
/// 1 at vertices, ½ from both ends at midpoints of edges. One component is stored for all (MAIJ). Collective.
petsc::Matrix embedding(const Space& linear, const Space& quadratic);

} // namespace signorini::fem
