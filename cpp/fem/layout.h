// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include <array>
#include <span>
#include <vector>

namespace signorini::fem {

/// A node that is in no cell of the mesh, such as the translation or the rotation of a rigid body. It is
/// coupled to others by constraints alone: the forms m, b and a are diagonal there (docs/method.md
/// section 1).
struct VirtualNode {
  std::array<double, 3> mass{};      ///< of components, m: kg, or of a rotation kg m²
  std::array<double, 3> damping{};   ///< b: N s/m, or N m s
  std::array<double, 3> stiffness{}; ///< a: N/m, or N m
  std::array<bool, 3> clamped{};     ///< components that are zero
};

/// Where the unknowns of a space are: first the mesh's nodes of each rank, then, on the last rank, the
/// virtual nodes. Vectors hold nodes × dim values, node by node.
class Layout {
public:
  /// This rank owns so many of the mesh's nodes; `virtual_nodes` are the same on every rank. Collective.
  Layout(MPI_Comm comm, int dim, int mesh_nodes, std::vector<VirtualNode> virtual_nodes);

  [[nodiscard]] int dim() const { return dim_; }
  /// The mesh's nodes that this rank owns.
  [[nodiscard]] int mesh_nodes() const { return mesh_nodes_; }
  /// The nodes that this rank owns.
  [[nodiscard]] int nodes() const { return mesh_nodes_ + (here_ ? static_cast<int>(virtual_.size()) : 0); }
  /// Global number of this rank's first dof.
  [[nodiscard]] PetscInt first_dof() const { return first_dof_; }
  /// Number of dofs on all ranks.
  [[nodiscard]] PetscInt dofs() const { return dofs_; }

  [[nodiscard]] const std::vector<VirtualNode>& virtual_nodes() const { return virtual_; }
  /// Whether this rank owns the virtual nodes.
  [[nodiscard]] bool here() const { return here_; }
  /// Global number of a virtual node's first dof.
  [[nodiscard]] PetscInt virtual_dof(std::size_t node) const {
    return dofs_ - static_cast<PetscInt>(virtual_.size() - node) * dim_;
  }

  /// A zero vector. Collective.
  [[nodiscard]] petsc::Vector vector() const;

  /// A matrix over the mesh's dofs, or from other columns to these, with rows for the virtual ones: a square
  /// one gets columns too, and `diagonal` (virtual nodes × dim) there. Returns `matrix` itself if there are
  /// no virtual nodes. Collective.
  [[nodiscard]] petsc::Matrix extended(petsc::Matrix matrix, std::span<const double> diagonal = {}) const;

private:
  MPI_Comm comm_;
  int dim_, mesh_nodes_;
  std::vector<VirtualNode> virtual_;
  bool here_;
  PetscInt first_dof_ = 0, dofs_ = 0;
};

} // namespace signorini::fem
