// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/cell_fields.h"
#include "base/dolfinx_versions.h"
#include "fem/compiled_forms.h"
#include "fem/function.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/fem/Expression.h>
#include <fmt/format.h>
#include <stdexcept>

namespace signorini::fem {

namespace {

constexpr std::size_t tensor_entries = 9;

/// Position of a cell's value in a cellwise constant field, counted in values.
std::size_t place(const Function& field, std::int32_t cell) {
  return static_cast<std::size_t>(field.function_space()->dofmap()->cell_dofs(cell)[0]);
}

} // namespace

double von_mises(std::span<const double, tensor_entries> stress) {
  const double mean = (stress[0] + stress[4] + stress[8]) / 3;
  double square = 0;
  for (std::size_t c = 0; c < stress.size(); ++c)
    square += std::pow(stress[c] - (c % 4 == 0 ? mean : 0), 2);
  return std::sqrt(1.5 * square);
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

  /// Branch of a material that relaxes.
  struct Branch {
    std::size_t part;
    std::shared_ptr<Function> q;
    Expression stress; ///< viscous stress at the velocity q, with the branch's moduli as viscosities
  };
  std::vector<Branch> branches;
  std::optional<Function> branch_stress; ///< stress of one branch; absent without branches
  bool relaxing = false;                 ///< whether the state last set has internal displacements

  Expressions(const Space& on, const std::vector<Part>& body)
      : space(on), parts(body), displacement(std::make_shared<Function>(on.dolfinx())),
        velocity(std::make_shared<Function>(on.dolfinx())) {
    for (std::size_t i = 0; i < parts.size(); ++i)
      add_branches(i);
    if (!branches.empty())
      branch_stress.emplace(cellwise(space.mesh(), shape(CellField::stress)));
  }

  void add_branches(std::size_t part) {
    const scene::Material& material = parts[part].material;
    const scene::ElasticModuli whole = material.instantaneous();
    for (const scene::Branch& branch : material.prony) {
      const ConstantValues moduli = of_moduli(material, {branch.k * whole.bulk, branch.g * whole.shear});
      const auto q = std::make_shared<Function>(space.dolfinx());
      branches.push_back({part, q, expression(CellField::stress, q, moduli)});
    }
  }

  /// Creates the expression of a field at the displacement last set and the velocity `rate`.
  [[nodiscard]] Expression expression(CellField field, const std::shared_ptr<Function>& rate,
                                      const ConstantValues& values) const {
    const std::map<std::string, std::shared_ptr<const Function>> motion{{"displacement", displacement},
                                                                        {"velocity", rate}};
    const ufcx_expression& code = *generated(space).fields.at(static_cast<std::size_t>(field));
    return dolfinx_versions::create_expression(code, motion, constants(values));
  }

  Field& of(CellField field) {
    if (const auto found = fields.find(field); found != fields.end())
      return found->second;
    Field made{Function(cellwise(space.mesh(), shape(field))), {}, false};
    for (const Part& part : parts)
      made.of_parts.push_back(expression(field, velocity, of_material(part.material)));
    return fields.emplace(field, std::move(made)).first->second;
  }

  /// Returns the values of a field for the state last set, computing them if they are not current.
  const Function& now(CellField field) {
    Field& found = of(field);
    if (found.current)
      return found.values;
    for (std::size_t i = 0; i < found.of_parts.size(); ++i)
      found.values.interpolate(found.of_parts[i], parts[i].cells);
    if (relaxing && field == CellField::stress)
      for (Branch& branch : branches)
        add_stress(branch, found.values);
    if (relaxing && field == CellField::von_mises)
      set_von_mises(now(CellField::stress), found.values);
    found.current = true;
    return found.values;
  }

  /// Adds the stress of a branch to the stress in the cells of its part.
  void add_stress(Branch& branch, Function& stress) {
    branch_stress->interpolate(branch.stress, parts[branch.part].cells);
    const std::span<const double> from(branch_stress->x()->array());
    const auto to = dolfinx_versions::entries(*stress.x());
    for (const std::int32_t cell : parts[branch.part].cells)
      for (std::size_t c = 0; c < tensor_entries; ++c)
        to[tensor_entries * place(stress, cell) + c] +=
            from[tensor_entries * place(*branch_stress, cell) + c];
  }

  /// Sets the von Mises stress in the cells of the materials that relax.
  void set_von_mises(const Function& stress, Function& values) const {
    const std::span<const double> from(stress.x()->array());
    const auto to = dolfinx_versions::entries(*values.x());
    for (const Part& part : parts)
      if (part.material.relaxes())
        for (const std::int32_t cell : part.cells)
          to[place(values, cell)] =
              von_mises(from.subspan(tensor_entries * place(stress, cell)).first<tensor_entries>());
  }
};

CellFields::CellFields(const Space& space, const std::vector<Part>& parts)
    : expressions_(std::make_unique<Expressions>(space, parts)) {}

CellFields::~CellFields() = default;

Shape CellFields::shape(CellField field) { return field == CellField::von_mises ? Shape{} : Shape{3, 3}; }

void CellFields::set(Vec y, Vec v, std::span<const petsc::Vector> q) {
  Expressions& all = *expressions_;
  if (!q.empty() && q.size() != all.branches.size())
    throw std::logic_error(fmt::format("a state with {} internal displacements was given for {} branches",
                                       q.size(), all.branches.size()));
  fem::set(*all.displacement, petsc::ReadArray(y));
  fem::set(*all.velocity, petsc::ReadArray(v));
  for (std::size_t j = 0; j < q.size(); ++j)
    fem::set(*all.branches[j].q, petsc::ReadArray(q[j]));
  all.relaxing = !q.empty();
  for (auto& [name, field] : all.fields)
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
  for (const std::int32_t cell : expressions_->space.mesh().owned_cells())
    of_cells.push_back(values.x()->array()[place(values, cell)]);
  return largest(expressions_->space, of_cells);
}

} // namespace signorini::fem
