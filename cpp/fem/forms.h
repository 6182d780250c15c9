// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "fem/space.h"
#include "mesh/mesh.h"
#include "scene/scene.h"
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace signorini::fem {

/// Part of the body with one material.
struct Part {
  scene::Material material;
  std::vector<std::int32_t> cells; ///< cells that this rank owns, local indices
};

/// Divides the cells that this rank owns into parts, one for each material. Collective. Throws UserError on
/// every rank if a material's group is missing or empty, or if a cell is in no group or in the groups of two
/// materials.
std::vector<Part> parts(const mesh::Mesh& mesh, const std::vector<scene::Material>& materials);

/// Bilinear forms of forms/viscoelasticity.py, by their names in that file; docs/method.md section 1.
enum class Form {
  L2,
  L2_surface,
  L2_cellwise,
  L2_cellwise_surface,
  springs,
  m,
  a,
  b,
  d,
  d_elastic,
  m_rho,
  a_young,
  a_poisson,
  b_kappa,
  b_eta
};

/// Digest of the compiled forms for simplices of dimension `dim`, functions of degree `degree` and, in the
/// plane, `model`; it changes if a form is edited. Throws std::logic_error if no forms were compiled for
/// these. Not collective.
std::string forms_digest(int dim, int degree, scene::PlaneModel model);

/// Assembles a form over the cells of the body's parts for a time step `tau`, s, without boundary conditions.
/// Returns a symmetric matrix of PETSc type `type` (AIJ or BAIJ) on V, whose block size is the space
/// dimension. In a part without viscosity d is replaced by d_elastic, and the entries of b are stored zeros:
/// all forms have the same nonzero pattern. The moduli of a material that relaxes are those after relaxation
/// or, in the form d, those of Material::during_step(). Collective. Throws std::runtime_error if the form has
/// a constant that the program does not provide, or has a measure other than dx(1).
petsc::Matrix assemble(const Space& space, Form form, const std::vector<Part>& parts, double tau,
                       const char* type);

/// Assembles a form like assemble(), but over the part with the number `part` only. The matrix has the
/// nonzero pattern of all parts, with stored zeros elsewhere. Collective.
petsc::Matrix assemble_one(const Space& space, Form form, const std::vector<Part>& parts, std::size_t part,
                           const char* type);

/// Returns the form m, b or a at virtual nodes with the values `nodes`, as many as the space has, as a matrix
/// of V that is zero for the mesh's dofs; null if all entries are zero. Collective.
petsc::Matrix assemble_virtual(const Space& space, const std::vector<VirtualNode>& nodes, Form form);

/// Assembles the stiffness against `moduli` (Pa) of the part with the number `part`: the form b with bulk and
/// shear modulus as κ and η. The matrix, in blocks (BAIJ), has entries between nodes of the part's cells, and
/// stored zeros on the rest of its diagonal. Collective.
petsc::Matrix assemble_elasticity(const Space& space, const std::vector<Part>& parts, std::size_t part,
                                  scene::ElasticModuli moduli);

/// Assembles the L2 product on V over a group of cells or facets (AIJ). Entries are nonzero only for nodes
/// of the group's cells or, for a group of facets, of the cells with a facet in the group. Collective. Throws
/// UserError, naming the scene's `key`, as mesh::Mesh::group_dimension does.
petsc::Matrix assemble_part(const Space& space, const std::string& group, const std::string& key);

/// Springs, or dashpots, per area of a surface, that act along and across its normal.
struct Springs {
  double normal = 0, tangential = 0;  ///< N/m³; of dashpots N s/m³
  std::vector<std::int32_t> facets{}; ///< facets of the surface: pairs of a cell and the facet's number in it
};

/// Returns the facets of a group that this rank owns, each as a pair of a cell and the facet's number in this
/// cell. Collective. Throws UserError, naming the scene's `key`, unless the group is one of facets.
std::vector<std::int32_t> sides(const Space& space, const std::string& group, const std::string& key);

/// Throws UserError, naming the scene's `key`, if a boundary group is on the axis of a body of revolution and
/// has no area. Collective.
void require_area(const Space& space, const std::string& group, const std::string& key);

/// Assembles the form `springs` over several surfaces, in blocks (BAIJ). Only nodes of cells at these
/// surfaces have entries. Collective.
petsc::Matrix assemble_springs(const Space& space, const std::vector<Springs>& surfaces);

/// Assembles ∫ u·φ for cellwise constant u (columns) and φ in V (rows) over a group of cells or facets, or
/// over the body if `group` is absent (AIJ). Collective. Throws UserError, naming the scene's `key`, as
/// mesh::Mesh::group_dimension does.
petsc::Matrix assemble_cellwise(const Space& space, const std::optional<std::string>& group,
                                const std::string& key);

} // namespace signorini::fem
