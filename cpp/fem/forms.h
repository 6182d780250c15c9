#pragma once
#include "base/petsc.h"
#include "fem/material_regions.h"
#include "fem/space.h"
#include <optional>

namespace signorini::fem {

/// The bilinear forms of forms/viscoelasticity.py, by their names there; docs/method.md section 1.
enum class Form { L2, L2_surface, L2_cellwise, L2_cellwise_surface, m, a, b, d, d_elastic };

/// Digest of the forms as compiled for simplices of dimension `dim` and functions of degree `degree`; it
/// changes if a form is edited. Throws std::logic_error if none were compiled. Not collective.
std::string signature(int dim, int degree);

/// Assembles a form over cells on V for the body's parts and a time step `tau`, s, without boundary
/// conditions: a symmetric matrix of PETSc type `type` (AIJ or BAIJ), its block size the space dimension. In
/// a part without viscosity b is zero, its zeros stored so that all forms have the same nonzero pattern, and
/// d is d_elastic. Collective. Throws std::runtime_error if the form has a constant that the program does not
/// provide, or is not over dx(1).
petsc::Matrix assemble(const Space& space, Form form, const std::vector<Part>& parts, double tau,
                       const char* type);

/// Assembles the L2 product over a group of cells or facets (AIJ); only rows of nodes of the group's cells or
/// facets have entries other than zero. Collective. Throws UserError, naming the scene's `key`, as
/// mesh::Mesh::group_dimension does.
petsc::Matrix assemble_part(const Space& space, const std::string& group, const std::string& key);

/// Assembles ∫ u·φ for cellwise constant u (columns) and φ in V (rows) over the body or a group of cells or
/// facets (AIJ). Collective. Throws as assemble_part does.
petsc::Matrix assemble_cellwise(const Space& space, const std::optional<std::string>& group,
                                const std::string& key);

} // namespace signorini::fem
