// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "fem/deformation.h"
#include "fem/space.h"
#include "mesh/mesh.h"
#include "scene/scene.h"
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace signorini::fem {

/// A part of the body and its material.
struct Part {
  scene::Material material;
  std::vector<std::int32_t> cells; ///< cells that this rank owns, local indices
};

/// The parts of the body, one for each material. Collective. Throws UserError, on every rank alike, if a
/// material's group is missing or empty, or if a cell is in none of the groups or in two of them.
std::vector<Part> parts(const mesh::Mesh& mesh, const std::vector<scene::Material>& materials);

/// The bilinear forms of forms/viscoelasticity.py, by their names there; docs/method.md section 1.
enum class Form {
  L2,
  L2_surface,
  L2_cellwise,
  L2_cellwise_surface,
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

/// Digest of the forms as compiled for simplices of dimension `dim` and functions of degree `degree`; it
/// changes if a form is edited. Throws std::logic_error if none were compiled. Not collective.
std::string signature(int dim, int degree);

/// Assembles a form over cells on V for the body's parts and a time step `tau`, s, without boundary
/// conditions. The matrix is symmetric, of PETSc type `type` (AIJ or BAIJ), its block size the space
/// dimension. In a part without viscosity d is d_elastic and b is zero, its zeros stored so that all forms
/// have the same nonzero pattern. Collective. Throws std::runtime_error if the form has a constant that the
/// program does not provide, or is not over dx(1).
petsc::Matrix assemble(const Space& space, Form form, const std::vector<Part>& parts, double tau,
                       const char* type);

/// Assembles a form like assemble(), but over one part of the body alone, by its number; the pattern is that
/// of all parts, with zeros elsewhere.
petsc::Matrix assemble_one(const Space& space, Form form, const std::vector<Part>& parts, std::size_t part,
                           const char* type);

/// Assembles the L2 product over a group of cells or facets (AIJ); only rows of nodes of the group's cells or
/// facets have entries other than zero. Collective. Throws UserError, naming the scene's `key`, as
/// mesh::Mesh::group_dimension does.
petsc::Matrix assemble_part(const Space& space, const std::string& group, const std::string& key);

/// Assembles ∫ u·φ for cellwise constant u (columns) and φ in V (rows) over the body or a group of cells or
/// facets (AIJ). Collective. Throws as assemble_part does.
petsc::Matrix assemble_cellwise(const Space& space, const std::optional<std::string>& group,
                                const std::string& key);

/// The fields of forms/viscoelasticity.py, by their names there; docs/method.md section 1.
enum class CellField { strain, stress, von_mises };

/// Fields of a motion that are constant on each cell: the mean of strain or stress over the cell, and the von
/// Mises stress of that mean.
class CellFields {
public:
  /// Sets the fields up for the body's parts, each with its material. Collective. Throws std::runtime_error
  /// if a field has a coefficient or constant that the program does not provide.
  CellFields(const Space& space, const std::vector<Part>& parts);
  ~CellFields();
  CellFields(const CellFields&) = delete;
  CellFields& operator=(const CellFields&) = delete;

  /// Shape of a value: (3, 3) for a tensor, in the plane too, empty for the von Mises stress.
  [[nodiscard]] static Shape shape(CellField field);

  /// Sets the displacement (m) and velocity (m/s) that the fields are evaluated for. Collective.
  void set(Vec y, Vec v);

  /// Values of a field (strain, or Pa) for the motion last set, those of cellwise(mesh, shape) that this rank
  /// owns; valid until the next call for this field. Collective.
  [[nodiscard]] std::span<const double> operator()(CellField field);

  /// Largest von Mises stress of the motion last set. Collective.
  [[nodiscard]] Largest largest_von_mises();

private:
  struct Expressions;
  std::unique_ptr<Expressions> expressions_;
};

} // namespace signorini::fem
