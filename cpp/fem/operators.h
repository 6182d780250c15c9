#pragma once
#include "fem/forms.h"
#include <optional>

namespace signorini::fem {

/// The dofs that clamps hold.
class Clamped {
public:
  /// Collective. Throws UserError if a group is missing or two clamps hold a dof differently.
  Clamped(const Space& space, const std::vector<scene::Clamp>& clamps);

  /// Owned dofs that are clamped, ascending local numbers.
  [[nodiscard]] const std::vector<int>& dofs() const { return dofs_; }
  [[nodiscard]] bool contains(int node, int component) const;

  /// Sets the clamped entries of a vector of V to zero.
  void clear(Vec x) const;

  /// Decouples the clamped dofs of a symmetric matrix: their rows and columns zero but for the diagonal,
  /// whose entry is returned. Collective.
  double decouple(Mat matrix) const;

private:
  std::vector<int> dofs_;
  int dim_;
  PetscInt first_dof_;
};

/// Numbers (0, 1, 2) of the components named, in their order; all of them where none is.
std::vector<int> component_numbers(const std::optional<std::vector<std::string>>& names, int dim);

/// The matrices of the body, no boundary condition applied; docs/method.md section 1. The upper half in blocks of
/// the space dimension (SBAIJ), which makes the products between two solves twice as fast as rows do; where a
/// form acts on each component alike, as L2 and m do, one component is stored for all (MAIJ).
struct Operators {
  petsc::Matrix M;                       ///< m, kg
  petsc::Matrix A;                       ///< a
  std::optional<petsc::Matrix> B;        ///< b; absent in an elastic body
  std::optional<petsc::Matrix> W;        ///< L2; absent where nothing is given by its density in the body
  std::optional<double> uniform_density; ///< ρ with M = ρ W, if there is one, kg/m³
};

/// The diagonal of one of them. Collective.
petsc::Vector diagonal(Mat matrix);

/// `densities`: whether W is wanted. Collective. Throws UserError unless every cell is of one of the materials.
Operators assemble_operators(const Space& space, const std::vector<scene::Material>& materials,
                             bool densities);

/// The L2 product over a part of the body (a group of cells) or a surface (a group of facets), stored as W
/// is: one component for all, with entries only where the part's own functions meet. Collective. Throws
/// UserError naming the scene's `key` if there is no such group.
petsc::Matrix assemble_L2(const Space& space, const std::string& group, const std::string& key);

/// What an L2 product, W or of assemble_L2, couples among some nodes (owned, ascending local numbers), in so
/// many components. Collective.
petsc::Matrix among_nodes(Mat L2, const std::vector<int>& nodes, int components);

/// Some of a matrix's columns (owned, ascending local numbers). Collective.
petsc::Matrix columns(Mat matrix, const std::vector<int>& columns);

/// The operator D of every step, from the form d (d_elastic without viscosity), in blocks (BAIJ). Collective.
/// Throws as assemble_operators does.
petsc::Matrix assemble_step_operator(const Space& space, const std::vector<scene::Material>& materials,
                                     double tau);

/// The operator m of the mass alone, in blocks (BAIJ). Collective. Throws as assemble_operators does.
petsc::Matrix assemble_mass(const Space& space, const std::vector<scene::Material>& materials);

/// The upper half of a symmetric matrix of blocks (SBAIJ). Collective.
petsc::Matrix symmetric_half(const petsc::Matrix& blocks);

/// D − c A, stored as Operators are. Collective.
petsc::Matrix shifted(Mat A, Mat D, double c);

} // namespace signorini::fem
