#pragma once
#include "base/petsc.h"
#include "fem/parts.h"
#include "fem/space.h"
#include <optional>

namespace signorini::fem {

/// The bilinear forms of forms/viscoelasticity.py, by their names there.
enum class Form { L2, L2_surface, L2_cellwise, L2_cellwise_surface, m, a, b, d, d_elastic };

/// Of the forms as they were compiled for simplices of a dimension and functions of a degree: another one where
/// one of them was edited. Throws std::logic_error if there are none.
std::string signature(int dim, int degree);

/// Assembles a form of cells on V for the body's parts and a time step, no boundary condition applied: a symmetric
/// matrix of PETSc type `type` (rows or blocks), its block size the space dimension. In a part without viscosity b is
/// zero, its zeros stored so that all forms have the same nonzeros, and d is d_elastic. Collective. Throws
/// std::runtime_error if the form asks for a constant that the program does not give, or is not over dx(1).
petsc::Matrix assemble(const Space& space, Form form, const std::vector<Part>& parts, double tau,
                       const char* type);

/// The L2 product over a group of cells or facets, in rows of which only those that the group touches have
/// entries other than zero. Collective. Throws UserError, naming the scene's `key`, as
/// mesh::Mesh::group_dimension does.
petsc::Matrix assemble_part(const Space& space, const std::string& group, const std::string& key);

/// ∫ u·φ for functions u that are constant on each cell (columns), over the body or a group of cells or
/// facets, in rows. Collective. Throws as assemble_part does.
petsc::Matrix assemble_cellwise(const Space& space, const std::optional<std::string>& group,
                                const std::string& key);

} // namespace signorini::fem
