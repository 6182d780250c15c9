// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/forms.h"
#include <optional>

namespace signorini::fem {

/// Dofs that clamps prescribe, and dofs of virtual nodes that are zero.
class DirichletDofs {
public:
  /// Collective. Throws UserError, on every rank, if a group is missing or two clamps prescribe different
  /// motions of a dof.
  DirichletDofs(const Space& space, const std::vector<scene::Clamp>& clamps);

  /// Owned dofs that are clamped, ascending local numbers.
  [[nodiscard]] const std::vector<int>& dofs() const { return dofs_; }
  /// Whether a component of an owned node (local number) is clamped. Not collective.
  [[nodiscard]] bool contains(int node, int component) const;

  /// Sets the clamped entries of a vector of V to zero. Not collective.
  void clear(Vec x) const;

  /// Decouples the clamped dofs of a symmetric matrix: sets their rows and columns to zero and their diagonal
  /// to the largest diagonal entry, which is returned. Collective.
  double decouple(Mat matrix) const;

private:
  std::vector<int> dofs_;
  int dim_;
  PetscInt first_dof_;
};

/// Numbers (0, 1, 2) of the components `given`, in their order; of all `dim` components if absent.
std::vector<int> component_numbers(const std::optional<std::vector<scene::Component>>& given, int dim);

/// Matrices of the body without boundary conditions; docs/method.md section 1. They are stored as upper
/// halves in blocks of the space dimension (SBAIJ), whose products are twice as fast as with AIJ. Forms that
/// act on each component alike, such as L2 and m, store one component for all (MAIJ).
struct Operators {
  petsc::Matrix M;                       ///< form m, kg
  petsc::Matrix A;                       ///< form a
  std::optional<petsc::Matrix> B;        ///< form b; absent if the body is elastic
  std::optional<petsc::Matrix> W;        ///< form L2; absent unless needed (densities)
  std::optional<double> uniform_density; ///< ρ with M = ρ W, if there is one, kg/m³
};

/// Diagonal of one of these matrices, of any type. Collective.
petsc::Vector diagonal(Mat matrix);

/// Assembles the matrices of the body; `densities`: whether W is needed, as for loads, nodal controls and an
/// objective over the whole body. Collective. Throws UserError unless every cell belongs to exactly one of
/// the materials.
Operators assemble_operators(const Space& space, const std::vector<scene::Material>& materials,
                             bool densities);

/// Assembles the L2 product over a part of the body (a group of cells) or a surface (a group of facets). It
/// is stored like W, one component for all (MAIJ), with entries only between nodes of the part. Collective.
/// Throws UserError naming the scene's `key` if there is no such group.
petsc::Matrix assemble_L2(const Space& space, const std::string& group, const std::string& key);

/// Restricts an L2 product, W or of assemble_L2, to some nodes (owned, ascending local numbers) and to a
/// number of components (MAIJ). Collective.
petsc::Matrix among_nodes(Mat L2, const std::vector<int>& nodes, int components);

/// Attaches the rigid motions, the near null space of a matrix of V, for multigrid. Collective.
void attach_rigid_motions(Mat matrix, const Space& space);

/// The submatrix of all rows and of some columns (owned, ascending local numbers). Collective.
petsc::Matrix columns(Mat matrix, const std::vector<int>& columns);

/// Assembles the operator D of every step, docs/method.md section 1, from the form d (d_elastic without
/// viscosity) for the time step `tau`, s, in blocks (BAIJ). Collective. Throws as assemble_operators does.
petsc::Matrix assemble_step_operator(const Space& space, const std::vector<scene::Material>& materials,
                                     double tau);

/// Assembles the derivative of M, A or B by a constant of one material, by its number, from one of the forms
/// m_rho … b_eta, in blocks (BAIJ). Collective. Throws as assemble_operators does.
petsc::Matrix assemble_rate(const Space& space, const std::vector<scene::Material>& materials,
                            std::size_t material, Form form);

/// Assembles the mass matrix M alone, in blocks (BAIJ). Collective. Throws as assemble_operators does.
petsc::Matrix assemble_mass(const Space& space, const std::vector<scene::Material>& materials);

/// The upper half of a symmetric matrix of blocks (SBAIJ). Collective.
petsc::Matrix symmetric_half(const petsc::Matrix& blocks);

/// D − c A as its upper half in blocks (SBAIJ). Collective.
petsc::Matrix shifted(Mat A, Mat D, double c);

} // namespace signorini::fem
