// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/forms.h"
#include "fem/relaxation.h"
#include "linalg/threaded_product.h"
#include <optional>

namespace signorini::fem {

/// Clamped dofs: dofs whose motion the scene's clamps prescribe, radial dofs on the axis of a body of
/// revolution, and dofs of virtual nodes that are fixed to zero.
class DirichletDofs {
public:
  /// Collects the clamped dofs. Collective. Throws UserError on every rank if a group is missing, if two
  /// clamps prescribe different motions of the same dof, and if a clamp moves the axis of a body of
  /// revolution radially.
  DirichletDofs(const Space& space, const std::vector<scene::Clamp>& clamps);

  /// Clamped dofs that this rank owns, by local number, ascending.
  [[nodiscard]] const std::vector<int>& dofs() const { return dofs_; }
  /// Whether a component (0, 1, 2) of an owned node (local number) is clamped. Not collective.
  [[nodiscard]] bool contains(int node, int component) const;

  /// Sets the clamped entries of a vector of V to zero. Not collective.
  void clear(Vec x) const;

  /// Decouples the clamped dofs of a symmetric matrix: sets their rows and columns to zero, and their
  /// diagonal entries to the largest diagonal entry of the matrix. Returns this entry. Collective.
  double decouple(Mat matrix) const;

private:
  std::vector<int> dofs_;
  int dim_;
  PetscInt first_dof_;
};

/// Converts components to numbers (0, 1, 2), in the order of `given`; returns the numbers of all `dim`
/// components if `given` is absent.
std::vector<int> component_numbers(const std::optional<std::vector<scene::Component>>& given, int dim);

/// Matrices of the body without boundary conditions; docs/method.md section 1. Each is stored as its upper
/// half in blocks of the space dimension (SBAIJ), which makes products twice as fast as with AIJ. Forms that
/// act alike on each component, such as L2 and m, store one component for all (MAIJ).
struct Operators {
  petsc::Matrix M;                       ///< form m: kg; in plane strain and plane stress kg/m
  petsc::Matrix A;                       ///< form a
  std::optional<petsc::Matrix> B;        ///< form b; absent if it is zero
  std::optional<petsc::Matrix> W;        ///< form L2; present only if requested (`densities`)
  std::optional<double> uniform_density; ///< density ρ with M = ρ W, kg/m³; absent if not uniform

  // Parts of A and B by which the surroundings act on the body, in blocks (BAIJ); null if zero.
  petsc::Matrix foundation_A; ///< springs of foundations, in A
  petsc::Matrix foundation_B; ///< dashpots of foundations, in B
  petsc::Matrix drag;         ///< mass-proportional damping Σ α M, in B

  bool viscous = false; ///< whether B has the form b of a material

  /// Branches of the materials that relax; absent if no material does. A has the long-term moduli.
  std::optional<Relaxation> relaxation;

  /// Whether forces of the surroundings depend on the body's motion, so that no rigid motion is free.
  [[nodiscard]] bool surrounded() const { return foundation_A || foundation_B || drag; }
  /// Adds the terms of the surroundings to a step operator D for the time step `tau`, s: drag, dashpots and
  /// springs. Collective.
  void add_surroundings(Mat D, double tau) const;
};

/// Diagonal of one of the matrices in Operators, of any storage type. Collective.
petsc::Vector diagonal(Mat matrix);

/// Assembles the matrices of the body. `densities`: whether W is needed, as it is for loads, nodal controls
/// and an objective over the whole body. Collective. Throws UserError unless every cell belongs to exactly
/// one material, and unless foundations are on groups of facets.
Operators assemble_operators(const Space& space, const std::vector<scene::Material>& materials,
                             bool densities, const std::vector<scene::Foundation>& foundations = {});

/// Assembles the L2 product over a part of the body (a group of cells) or a surface (a group of facets). It
/// is stored like W, one component for all (MAIJ), and has entries only between nodes of the group.
/// Collective. Throws UserError naming the scene's `key` if the group does not exist.
petsc::Matrix assemble_L2(const Space& space, const std::string& group, const std::string& key);

/// Restricts an L2 product, either W or the result of assemble_L2(), to `nodes` (owned, ascending local
/// numbers) and to `components` components per node (MAIJ). Collective.
petsc::Matrix among_nodes(Mat L2, const std::vector<int>& nodes, int components);

/// Attaches the rigid motions to a matrix of V as its near null space, for multigrid. Collective.
void attach_rigid_motions(Mat matrix, const Space& space);

/// Extracts some columns of a matrix, with all rows. `columns`: owned columns, ascending local numbers.
/// Collective.
petsc::Matrix columns(Mat matrix, const std::vector<int>& columns);

/// Assembles the step operator D (docs/method.md section 1) from the form d for the time step `tau`, s, in
/// blocks (BAIJ), without Operators::add_surroundings(); parts without viscosity use d_elastic. The moduli of
/// materials that relax are those of a step of length `tau`, Material::during_step(). Collective. Throws as
/// assemble_operators does.
petsc::Matrix assemble_step_operator(const Space& space, const std::vector<scene::Material>& materials,
                                     double tau);

/// Assembles the derivative of M, A or B with respect to a constant of the material with the number
/// `material`, in blocks (BAIJ). `form`: one of m_rho … b_eta, which determines the matrix and the constant.
/// Collective. Throws as assemble_operators does.
petsc::Matrix assemble_rate(const Space& space, const std::vector<scene::Material>& materials,
                            std::size_t material, Form form);

/// Assembles the mass matrix M, in blocks (BAIJ). Collective. Throws as assemble_operators does.
petsc::Matrix assemble_mass(const Space& space, const std::vector<scene::Material>& materials);

/// Returns D − c A as its upper half in blocks (SBAIJ). Collective.
petsc::Matrix shifted(Mat A, Mat D, double c);

} // namespace signorini::fem
