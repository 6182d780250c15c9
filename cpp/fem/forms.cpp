// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/forms.h"
#include "base/collective.h"
#include "base/digest.h"
#include "base/text.h"
#include "base/timers.h"
#include "fem/compiled_forms.h"
#include <algorithm>
#include <dolfinx/fem/petsc.h>
#include <dolfinx/la/petsc.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/utils.h>
#include <fmt/format.h>
#include <numeric>

namespace signorini::fem {

namespace {

/// Midpoint of a cell as text for messages, m.
std::string place(const mesh::Mesh& mesh, std::int32_t cell) {
  const std::vector<double> x =
      dolfinx::mesh::compute_midpoints(*mesh.dolfinx(), mesh.dim(), std::vector{cell});
  return point_text(x.data(), mesh.dim());
}

/// Throws UserError unless every cell that this rank owns is in exactly one part.
void require_one_material(const mesh::Mesh& mesh, const std::vector<Part>& parts) {
  constexpr std::size_t none = -1;
  std::vector<std::size_t> part_of(mesh.owned_cells().size(), none);
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (std::int32_t cell : parts[p].cells) {
      std::size_t& part = part_of[static_cast<std::size_t>(cell)];
      if (part != none)
        throw UserError(fmt::format("material: the cell at {} is in the groups \"{}\" and \"{}\" of two "
                                    "materials; give every cell one material",
                                    place(mesh, cell), *parts[part].material.on, *parts[p].material.on));
      part = p;
    }
  const auto found = std::ranges::find(part_of, none);
  if (found == part_of.end())
    return;
  std::vector<std::string> groups;
  for (const Part& part : parts)
    groups.push_back(*part.material.on);
  throw UserError(
      fmt::format("material: the cell at {} is in no group of a material ({}); give every cell one material",
                  place(mesh, static_cast<std::int32_t>(found - part_of.begin())), list(groups)));
}

} // namespace

std::vector<Part> parts(const mesh::Mesh& mesh, const std::vector<scene::Material>& materials) {
  std::vector<Part> parts;
  for (std::size_t i = 0; i < materials.size(); ++i)
    parts.push_back({materials[i], materials[i].on
                                       ? mesh.cells(*materials[i].on, fmt::format("material[{}].on", i))
                                       : mesh.owned_cells()});
  on_all_ranks(mesh.comm(), [&] { require_one_material(mesh, parts); });
  return parts;
}

namespace {

/// Adds a form over `entities` to a matrix.
void add(const Space& space, Form form, const std::vector<std::int32_t>& entities,
         const ConstantValues& values, Mat matrix) {
  ++count(std::string("assembled ") + name(form));
  dolfinx::fem::assemble_matrix(dolfinx::la::petsc::Matrix::set_block_fn(matrix, ADD_VALUES),
                                compile(space, form, entities, values), {});
}

void finish(Mat matrix) {
  petsc::check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  petsc::check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
}

/// Creates a matrix without values, with the nonzero pattern of a form over all parts. Collective.
petsc::Matrix empty(const Space& space, Form form, const std::vector<Part>& parts, const char* type) {
  std::vector<std::int32_t> all;
  for (const Part& part : parts)
    all.insert(all.end(), part.cells.begin(), part.cells.end());
  std::ranges::sort(all);
  return petsc::Matrix(dolfinx::fem::petsc::create_matrix(compile(space, form, all, {}), type));
}

/// Creates a matrix in blocks (BAIJ) with the nonzero pattern of a form over `cells`, and stores zeros on its
/// whole diagonal: without them PETSc does not convert a matrix to its upper half. Collective.
petsc::Matrix empty_with_diagonal(const Space& space, Form form, const std::vector<std::int32_t>& cells) {
  dolfinx::la::SparsityPattern pattern =
      dolfinx::fem::create_sparsity_pattern(compile(space, form, cells, {}));
  std::vector<std::int32_t> nodes(static_cast<std::size_t>(space.owned_nodes()));
  std::iota(nodes.begin(), nodes.end(), 0);
  pattern.insert_diagonal(nodes);
  pattern.finalize();
  petsc::Matrix matrix(dolfinx::la::petsc::create_matrix(space.comm(), pattern, MATBAIJ));
  auto insert = dolfinx::la::petsc::Matrix::set_block_fn(matrix, ADD_VALUES);
  const std::vector<PetscScalar> zeros(static_cast<std::size_t>(space.dim() * space.dim()), 0);
  for (const std::int32_t& node : nodes)
    insert(std::span(&node, 1), std::span(&node, 1), zeros);
  return matrix;
}

petsc::Matrix symmetric(petsc::Matrix matrix) {
  petsc::check(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE));
  petsc::check(MatSetOption(matrix, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  return matrix;
}

/// Selects the facets that this rank owns, each as a pair of a cell and the facet's number in this cell. For
/// an inner facet either cell can be taken, since functions of V are continuous.
std::vector<std::int32_t> sides(const Space& space, const std::vector<std::int32_t>& facets) {
  const auto topology = space.mesh().dolfinx()->topology();
  const int dim = topology->dim();
  const auto cells_of = topology->connectivity(dim - 1, dim),
             facets_of = topology->connectivity(dim, dim - 1);
  std::vector<std::int32_t> sides;
  for (std::int32_t facet : facets) {
    if (facet >= topology->index_map(dim - 1)->size_local())
      continue;
    const std::int32_t cell = cells_of->links(facet).front();
    const auto own = facets_of->links(cell);
    sides.push_back(cell);
    sides.push_back(static_cast<std::int32_t>(std::ranges::find(own, facet) - own.begin()));
  }
  return sides;
}

/// Assembles a form that has no material constants over `entities` (AIJ). Collective.
petsc::Matrix assemble_over(const Space& space, Form form, const std::vector<std::int32_t>& entities) {
  petsc::Matrix matrix(dolfinx::fem::petsc::create_matrix(compile(space, form, entities, {}), MATAIJ));
  add(space, form, entities, {}, matrix);
  finish(matrix);
  return matrix;
}

/// Assembles the form `volume` over a group of cells, or the form `surface` over a group of facets (AIJ).
/// Collective.
petsc::Matrix assemble_over(const Space& space, const std::string& group, const std::string& key, Form volume,
                            Form surface) {
  return space.mesh().group_dimension(group, key) < space.dim()
             ? assemble_over(space, surface, sides(space, group, key))
             : assemble_over(space, volume, space.mesh().cells(group, key));
}

/// Diagonal entries of a form at virtual nodes (virtual nodes × dim); those of d are m + τ/2 b + τ²/4 a.
std::vector<double> diagonal_of(const std::vector<VirtualNode>& nodes, int dim, Form form, double tau) {
  std::vector<double> diagonal;
  for (const VirtualNode& node : nodes)
    for (std::size_t c = 0; c < static_cast<std::size_t>(dim); ++c)
      diagonal.push_back(form == Form::m   ? node.mass[c]
                         : form == Form::b ? node.damping[c]
                         : form == Form::a ? node.stiffness[c]
                         : form == Form::d
                             ? node.mass[c] + tau / 2 * node.damping[c] + tau * tau / 4 * node.stiffness[c]
                             : 0);
  return diagonal;
}

} // namespace

std::string forms_digest(int dim, int degree, scene::PlaneModel model) {
  Digest digest;
  for (const ufcx_form* form : generated(dim, degree, model).forms)
    digest.add(form->signature);
  return digest.text();
}

petsc::Matrix assemble(const Space& space, Form form, const std::vector<Part>& parts, double tau,
                       const char* type) {
  petsc::Matrix matrix = empty(space, form, parts, type);
  const bool of_a_step = form == Form::d;
  for (const Part& part : parts) {
    const bool elastic = !part.material.viscous();
    add(space, of_a_step && elastic ? Form::d_elastic : form, part.cells,
        of_a_step ? of_step(part.material, tau) : of_material(part.material), matrix);
  }
  finish(matrix);
  return symmetric(space.layout().extended(
      std::move(matrix), diagonal_of(space.layout().virtual_nodes(), space.dim(), form, tau)));
}

petsc::Matrix assemble_virtual(const Space& space, const std::vector<VirtualNode>& nodes, Form form) {
  constexpr double no_tau = 0; // for forms without a time step
  const std::vector<double> diagonal = diagonal_of(nodes, space.dim(), form, no_tau);
  if (std::ranges::all_of(diagonal, [](double entry) { return entry == 0; }))
    return {};
  return space.layout().diagonal(diagonal);
}

petsc::Matrix assemble_one(const Space& space, Form form, const std::vector<Part>& parts, std::size_t part,
                           const char* type) {
  petsc::Matrix matrix = empty(space, form, parts, type);
  auto insert = dolfinx::la::petsc::Matrix::set_block_fn(matrix, ADD_VALUES);
  std::vector<PetscScalar> zeros;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (i != part)
      dolfinx::fem::assemble_matrix(
          [&](std::span<const std::int32_t> rows, std::span<const std::int32_t> columns,
              std::span<const PetscScalar> values) {
            zeros.assign(values.size(), 0);
            return insert(rows, columns, std::span<const PetscScalar>(zeros));
          },
          compile(space, form, parts[i].cells, of_material(parts[i].material)), {});
  add(space, form, parts[part].cells, of_material(parts[part].material), matrix);
  finish(matrix);
  return symmetric(space.layout().extended(std::move(matrix)));
}

petsc::Matrix assemble_elasticity(const Space& space, const std::vector<Part>& parts, std::size_t part,
                                  scene::ElasticModuli moduli) {
  const std::vector<std::int32_t>& cells = parts[part].cells;
  petsc::Matrix matrix = empty_with_diagonal(space, Form::b, cells);
  add(space, Form::b, cells, of_moduli(parts[part].material, moduli), matrix);
  finish(matrix);
  return symmetric(space.layout().extended(std::move(matrix)));
}

petsc::Matrix assemble_part(const Space& space, const std::string& group, const std::string& key) {
  return symmetric(space.layout().extended(assemble_over(space, group, key, Form::L2, Form::L2_surface)));
}

void require_area(const Space& space, const std::string& group, const std::string& key) {
  if (!space.mesh().axisymmetric())
    return;
  int off_axis = !space.nodes_on(group, key, true).empty();
  MPI_Allreduce(MPI_IN_PLACE, &off_axis, 1, MPI_INT, MPI_MAX, space.comm());
  if (off_axis == 0)
    throw UserError(
        fmt::format("{}: found \"{}\", a group on the axis, which is inside the body and has no area; "
                    "choose another group",
                    key, group));
}

std::vector<std::int32_t> sides(const Space& space, const std::string& group, const std::string& key) {
  require_area(space, group, key);
  return sides(space, space.mesh().facets(group, key));
}

petsc::Matrix assemble_springs(const Space& space, const std::vector<Springs>& surfaces) {
  std::vector<std::int32_t> all;
  for (const Springs& surface : surfaces)
    all.insert(all.end(), surface.facets.begin(), surface.facets.end());
  petsc::Matrix matrix(dolfinx::fem::petsc::create_matrix(compile(space, Form::springs, all, {}), MATBAIJ));
  for (const Springs& surface : surfaces)
    add(space, Form::springs, surface.facets,
        {.k_normal = surface.normal, .k_tangential = surface.tangential}, matrix);
  finish(matrix);
  return symmetric(space.layout().extended(std::move(matrix)));
}

petsc::Matrix assemble_cellwise(const Space& space, const std::optional<std::string>& group,
                                const std::string& key) {
  return space.layout().extended(
      group ? assemble_over(space, *group, key, Form::L2_cellwise, Form::L2_cellwise_surface)
            : assemble_over(space, Form::L2_cellwise, space.mesh().owned_cells()));
}

} // namespace signorini::fem
