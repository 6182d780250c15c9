// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/forms.h"
#include "base/collective.h"
#include "base/digest.h"
#include "base/dolfinx_versions.h"
#include "base/text.h"
#include "base/timers.h"
#include "fem/function.h"
#include "viscoelasticity_tetrahedron_1.h"
#include "viscoelasticity_tetrahedron_2.h"
#include "viscoelasticity_triangle_1.h"
#include "viscoelasticity_triangle_2.h"
#include <algorithm>
#include <array>
#include <dolfinx/fem/Expression.h>
#include <dolfinx/fem/petsc.h>
#include <dolfinx/la/petsc.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/utils.h>
#include <fmt/format.h>
#include <stdexcept>

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

/// Generated code of all forms, in the order of enum Form, and of all fields, in the order of enum CellField.
struct Generated {
  std::array<const ufcx_form*, 15> forms;
  std::array<const ufcx_expression*, 3> fields;
};
constexpr std::array names{
    "L2",        "L2_surface", "L2_cellwise", "L2_cellwise_surface", "springs", "m",    "a", "b", "d",
    "d_elastic", "m_rho",      "a_young",     "a_poisson",           "b_kappa", "b_eta"};

#define SIGNORINI_GENERATED(cell, degree)                                                                    \
  Generated {                                                                                                \
    {form_viscoelasticity_##cell##_##degree##_L2,                                                            \
     form_viscoelasticity_##cell##_##degree##_L2_surface,                                                    \
     form_viscoelasticity_##cell##_##degree##_L2_cellwise,                                                   \
     form_viscoelasticity_##cell##_##degree##_L2_cellwise_surface,                                           \
     form_viscoelasticity_##cell##_##degree##_springs,                                                       \
     form_viscoelasticity_##cell##_##degree##_m,                                                             \
     form_viscoelasticity_##cell##_##degree##_a,                                                             \
     form_viscoelasticity_##cell##_##degree##_b,                                                             \
     form_viscoelasticity_##cell##_##degree##_d,                                                             \
     form_viscoelasticity_##cell##_##degree##_d_elastic,                                                     \
     form_viscoelasticity_##cell##_##degree##_m_rho,                                                         \
     form_viscoelasticity_##cell##_##degree##_a_young,                                                       \
     form_viscoelasticity_##cell##_##degree##_a_poisson,                                                     \
     form_viscoelasticity_##cell##_##degree##_b_kappa,                                                       \
     form_viscoelasticity_##cell##_##degree##_b_eta},                                                        \
    {                                                                                                        \
      expression_viscoelasticity_##cell##_##degree##_strain,                                                 \
          expression_viscoelasticity_##cell##_##degree##_stress,                                             \
          expression_viscoelasticity_##cell##_##degree##_von_mises                                           \
    }                                                                                                        \
  }

Generated generated(int dim, int degree) {
  if (dim == 2 && degree == 1)
    return SIGNORINI_GENERATED(triangle, 1);
  if (dim == 2 && degree == 2)
    return SIGNORINI_GENERATED(triangle, 2);
  if (dim == 3 && degree == 1)
    return SIGNORINI_GENERATED(tetrahedron, 1);
  if (dim == 3 && degree == 2)
    return SIGNORINI_GENERATED(tetrahedron, 2);
  throw std::logic_error("no forms were compiled for this cell and degree (CMakeLists.txt)");
}

using Compiled = dolfinx::fem::Form<PetscScalar, double>;

using Constants = std::map<std::string, std::shared_ptr<const dolfinx::fem::Constant<PetscScalar>>>;

/// Constants of forms and fields, by their names in forms/viscoelasticity.py. A material without viscosity
/// has the viscosities zero.
Constants constants(const scene::Material& material, double tau, const Springs& springs = {}) {
  const auto constant = [](double value) {
    return std::make_shared<dolfinx::fem::Constant<PetscScalar>>(value);
  };
  const scene::Viscosity viscosity = material.total_viscosity();
  return {{"rho", constant(material.density)},     {"young", constant(material.young)},
          {"poisson", constant(material.poisson)}, {"kappa", constant(viscosity.bulk)},
          {"eta", constant(viscosity.shear)},      {"tau", constant(tau)},
          {"k_normal", constant(springs.normal)},  {"k_tangential", constant(springs.tangential)}};
}

/// Compiles a form over `entities`: cells, or facets given as pairs of a cell and the facet's number in this
/// cell.
Compiled compile(const Space& space, Form form, const scene::Material& material, double tau,
                 const std::vector<std::int32_t>& entities, const Springs& springs = {}) {
  using enum dolfinx::fem::IntegralType;
  const bool cellwise_trial = form == Form::L2_cellwise || form == Form::L2_cellwise_surface;
  const bool surface = form == Form::L2_surface || form == Form::L2_cellwise_surface || form == Form::springs;
  const auto type = surface ? exterior_facet : cell;
  const std::shared_ptr<const dolfinx::fem::FunctionSpace<double>> V = space.dolfinx();
  const ufcx_form& code = *generated(space.dim(), space.degree()).forms.at(static_cast<std::size_t>(form));
  // Check the generated code, since dolfinx leaves out integrals without entities.
  constexpr int types = 3; // cells, exterior and interior facets
  const int at = code.form_integral_offsets[static_cast<int>(type)];
  if (code.form_integral_offsets[types] != 1 || at != 0 ||
      code.form_integral_offsets[static_cast<int>(type) + 1] != 1 || code.form_integral_ids[at] != 1)
    throw std::runtime_error(
        "forms/viscoelasticity.py: a form must use the measure dx(1) alone, a form on a surface ds(1) alone");
  return dolfinx::fem::create_form<PetscScalar, double>(
      code, {V, cellwise_trial ? cellwise(space.mesh()) : V}, {}, constants(material, tau, springs),
      {{type, {{1, entities}}}}, {});
}

void add(const Space& space, Form form, const scene::Material& material, double tau,
         const std::vector<std::int32_t>& entities, Mat matrix, const Springs& springs = {}) {
  ++count(std::string("assembled ") + names.at(static_cast<std::size_t>(form)));
  dolfinx::fem::assemble_matrix(dolfinx::la::petsc::Matrix::set_block_fn(matrix, ADD_VALUES),
                                compile(space, form, material, tau, entities, springs), {});
}

void finish(Mat matrix) {
  petsc::check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  petsc::check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
}

/// Creates a matrix without values, with the nonzero pattern of a form over all parts. Collective.
petsc::Matrix empty(const Space& space, Form form, const std::vector<Part>& parts, double tau,
                    const char* type) {
  std::vector<std::int32_t> all;
  for (const Part& part : parts)
    all.insert(all.end(), part.cells.begin(), part.cells.end());
  std::ranges::sort(all);
  return petsc::Matrix(dolfinx::fem::petsc::create_matrix(compile(space, form, {}, tau, all), type));
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
  constexpr double no_tau = 0;
  petsc::Matrix matrix(
      dolfinx::fem::petsc::create_matrix(compile(space, form, {}, no_tau, entities), MATAIJ));
  add(space, form, {}, no_tau, entities, matrix);
  finish(matrix);
  return matrix;
}

/// Assembles the form `volume` over a group of cells, or the form `surface` over a group of facets (AIJ).
/// Collective.
petsc::Matrix assemble_over(const Space& space, const std::string& group, const std::string& key, Form volume,
                            Form surface) {
  return space.mesh().group_dimension(group, key) < space.dim()
             ? assemble_over(space, surface, sides(space, space.mesh().facets(group, key)))
             : assemble_over(space, volume, space.mesh().cells(group, key));
}

/// Diagonal entries of a form at the virtual nodes (virtual nodes × dim); those of d are m + τ/2 b + τ²/4 a.
std::vector<double> of_virtual_nodes(const Space& space, Form form, double tau) {
  std::vector<double> diagonal;
  for (const VirtualNode& node : space.layout().virtual_nodes())
    for (std::size_t c = 0; c < static_cast<std::size_t>(space.dim()); ++c)
      diagonal.push_back(form == Form::m   ? node.mass[c]
                         : form == Form::b ? node.damping[c]
                         : form == Form::a ? node.stiffness[c]
                         : form == Form::d
                             ? node.mass[c] + tau / 2 * node.damping[c] + tau * tau / 4 * node.stiffness[c]
                             : 0);
  return diagonal;
}

} // namespace

std::string forms_digest(int dim, int degree) {
  Digest digest;
  for (const ufcx_form* form : generated(dim, degree).forms)
    digest.add(form->signature);
  return digest.text();
}

petsc::Matrix assemble(const Space& space, Form form, const std::vector<Part>& parts, double tau,
                       const char* type) {
  petsc::Matrix matrix = empty(space, form, parts, tau, type);
  for (const Part& part : parts) {
    const bool elastic = !part.material.viscous();
    add(space, form == Form::d && elastic ? Form::d_elastic : form, part.material, tau, part.cells, matrix);
  }
  finish(matrix);
  return symmetric(space.layout().extended(std::move(matrix), of_virtual_nodes(space, form, tau)));
}

petsc::Matrix assemble_one(const Space& space, Form form, const std::vector<Part>& parts, std::size_t part,
                           const char* type) {
  constexpr double no_tau = 0;
  petsc::Matrix matrix = empty(space, form, parts, no_tau, type);
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
          compile(space, form, parts[i].material, no_tau, parts[i].cells), {});
  add(space, form, parts[part].material, no_tau, parts[part].cells, matrix);
  finish(matrix);
  return symmetric(space.layout().extended(std::move(matrix)));
}

petsc::Matrix assemble_part(const Space& space, const std::string& group, const std::string& key) {
  return symmetric(space.layout().extended(assemble_over(space, group, key, Form::L2, Form::L2_surface)));
}

std::vector<std::int32_t> sides(const Space& space, const std::string& group, const std::string& key) {
  return sides(space, space.mesh().facets(group, key));
}

petsc::Matrix assemble_springs(const Space& space, const std::vector<Springs>& surfaces) {
  constexpr double no_tau = 0;
  std::vector<std::int32_t> all;
  for (const Springs& surface : surfaces)
    all.insert(all.end(), surface.facets.begin(), surface.facets.end());
  petsc::Matrix matrix(
      dolfinx::fem::petsc::create_matrix(compile(space, Form::springs, {}, no_tau, all), MATBAIJ));
  for (const Springs& surface : surfaces)
    add(space, Form::springs, {}, no_tau, surface.facets, matrix, surface);
  finish(matrix);
  return symmetric(space.layout().extended(std::move(matrix)));
}

petsc::Matrix assemble_cellwise(const Space& space, const std::optional<std::string>& group,
                                const std::string& key) {
  return space.layout().extended(
      group ? assemble_over(space, *group, key, Form::L2_cellwise, Form::L2_cellwise_surface)
            : assemble_over(space, Form::L2_cellwise, space.mesh().owned_cells()));
}

struct CellFields::Expressions {
  using Expression = dolfinx::fem::Expression<PetscScalar, double>;
  const Space& space;
  std::vector<Part> parts;
  std::shared_ptr<Function> displacement, velocity;

  struct Field {
    Function values;
    std::vector<Expression> of_parts;
    bool current = false; ///< whether `values` belong to the state last set
  };
  std::map<CellField, Field> fields; ///< fields evaluated so far

  Field& of(CellField field) {
    if (const auto found = fields.find(field); found != fields.end())
      return found->second;
    const std::map<std::string, std::shared_ptr<const Function>> motion{{"displacement", displacement},
                                                                        {"velocity", velocity}};
    const ufcx_expression& code =
        *generated(space.dim(), space.degree()).fields.at(static_cast<std::size_t>(field));
    constexpr double no_tau = 0;
    Field made{Function(cellwise(space.mesh(), shape(field))), {}, false};
    for (const Part& part : parts)
      made.of_parts.push_back(
          dolfinx_versions::create_expression(code, motion, constants(part.material, no_tau)));
    return fields.emplace(field, std::move(made)).first->second;
  }

  /// Returns the values of a field for the state last set, computing them if they are not current.
  const Function& now(CellField field) {
    Field& found = of(field);
    for (std::size_t i = 0; !found.current && i < found.of_parts.size(); ++i)
      found.values.interpolate(found.of_parts[i], parts[i].cells);
    found.current = true;
    return found.values;
  }
};

CellFields::CellFields(const Space& space, const std::vector<Part>& parts)
    : expressions_(new Expressions{space,
                                   parts,
                                   std::make_shared<Function>(space.dolfinx()),
                                   std::make_shared<Function>(space.dolfinx()),
                                   {}}) {}

CellFields::~CellFields() = default;

Shape CellFields::shape(CellField field) { return field == CellField::von_mises ? Shape{} : Shape{3, 3}; }

void CellFields::set(Vec y, Vec v) {
  fem::set(*expressions_->displacement, petsc::ReadArray(y));
  fem::set(*expressions_->velocity, petsc::ReadArray(v));
  for (auto& [name, field] : expressions_->fields)
    field.current = false;
}

std::span<const double> CellFields::operator()(CellField field) {
  const Function& values = expressions_->now(field);
  const auto& dofmap = *values.function_space()->dofmap();
  return std::span<const double>(values.x()->array())
      .first(static_cast<std::size_t>(dofmap.index_map->size_local() * dofmap.index_map_bs()));
}

Largest CellFields::largest_von_mises() {
  const Function& values = expressions_->now(CellField::von_mises);
  std::vector<double> of_cells;
  for (const std::int32_t cell : expressions_->space.mesh().owned_cells()) {
    const std::int32_t place = values.function_space()->dofmap()->cell_dofs(cell)[0];
    of_cells.push_back(values.x()->array()[static_cast<std::size_t>(place)]);
  }
  return largest(expressions_->space, of_cells);
}

} // namespace signorini::fem
