#include "fem/forms.h"
#include "base/counters.h"
#include "viscoelasticity_tetrahedron_1.h"
#include "viscoelasticity_tetrahedron_2.h"
#include "viscoelasticity_triangle_1.h"
#include "viscoelasticity_triangle_2.h"
#include <array>
#include <dolfinx/fem/petsc.h>
#include <dolfinx/la/petsc.h>
#include <stdexcept>

namespace signorini::fem {
namespace {

/// Generated code of every form, in the order of enum Form.
using Generated = std::array<const ufcx_form*, 6>;
constexpr std::array names{"L2", "m", "a", "b", "d", "d_elastic"};

#define SIGNORINI_GENERATED(cell, degree)                                                                    \
  Generated {                                                                                                \
    form_viscoelasticity_##cell##_##degree##_L2, form_viscoelasticity_##cell##_##degree##_m,                 \
        form_viscoelasticity_##cell##_##degree##_a, form_viscoelasticity_##cell##_##degree##_b,              \
        form_viscoelasticity_##cell##_##degree##_d, form_viscoelasticity_##cell##_##degree##_d_elastic       \
  }

Generated generated(const Space& space) {
  if (space.dim() == 2 && space.degree() == 1)
    return SIGNORINI_GENERATED(triangle, 1);
  if (space.dim() == 2 && space.degree() == 2)
    return SIGNORINI_GENERATED(triangle, 2);
  if (space.dim() == 3 && space.degree() == 1)
    return SIGNORINI_GENERATED(tetrahedron, 1);
  if (space.dim() == 3 && space.degree() == 2)
    return SIGNORINI_GENERATED(tetrahedron, 2);
  throw std::logic_error("no forms were compiled for this cell and degree (CMakeLists.txt)");
}

} // namespace

petsc::Matrix assemble(const Space& space, Form form, const scene::Material& material, double tau,
                       const char* type) {
  using Constant = dolfinx::fem::Constant<PetscScalar>;
  const auto constant = [](double value) { return std::make_shared<Constant>(value); };
  const scene::Viscosity viscosity = material.viscosity.value_or(scene::Viscosity{});
  const std::map<std::string, std::shared_ptr<const Constant>> constants{
      {"rho", constant(material.density)},     {"young", constant(material.young)},
      {"poisson", constant(material.poisson)}, {"kappa", constant(viscosity.bulk)},
      {"eta", constant(viscosity.shear)},      {"tau", constant(tau)}};
  const std::shared_ptr<const dolfinx::fem::FunctionSpace<double>> V = space.dolfinx();
  const auto compiled = dolfinx::fem::create_form<PetscScalar, double>(
      *generated(space).at(static_cast<std::size_t>(form)), {V, V}, {}, constants, {}, {});
  ++count(std::string("assembled ") + names.at(static_cast<std::size_t>(form)));
  petsc::Matrix matrix(dolfinx::fem::petsc::create_matrix(compiled, type));
  dolfinx::fem::assemble_matrix(dolfinx::la::petsc::Matrix::set_block_fn(matrix, ADD_VALUES), compiled, {});
  petsc::check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  petsc::check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  petsc::check(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE));
  petsc::check(MatSetOption(matrix, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  return matrix;
}

} // namespace signorini::fem
