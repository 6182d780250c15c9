// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/compiled_forms.h"
#include "fem/cell_fields.h"
#include "viscoelasticity_tetrahedron_1.h"
#include "viscoelasticity_tetrahedron_2.h"
#include "viscoelasticity_triangle_1.h"
#include "viscoelasticity_triangle_1_axisymmetric.h"
#include "viscoelasticity_triangle_1_plane_stress.h"
#include "viscoelasticity_triangle_2.h"
#include "viscoelasticity_triangle_2_axisymmetric.h"
#include "viscoelasticity_triangle_2_plane_stress.h"
#include <dolfinx/fem/utils.h>
#include <stdexcept>
#include <tuple>

namespace signorini::fem {

const char* name(Form form) {
  constexpr std::array names{
      "L2",        "L2_surface", "L2_cellwise", "L2_cellwise_surface", "springs", "m",    "a", "b", "d",
      "d_elastic", "m_rho",      "a_young",     "a_poisson",           "b_kappa", "b_eta"};
  return names.at(static_cast<std::size_t>(form));
}

#define SIGNORINI_GENERATED(which)                                                                           \
  Generated {                                                                                                \
    {form_viscoelasticity_##which##_L2,          form_viscoelasticity_##which##_L2_surface,                  \
     form_viscoelasticity_##which##_L2_cellwise, form_viscoelasticity_##which##_L2_cellwise_surface,         \
     form_viscoelasticity_##which##_springs,     form_viscoelasticity_##which##_m,                           \
     form_viscoelasticity_##which##_a,           form_viscoelasticity_##which##_b,                           \
     form_viscoelasticity_##which##_d,           form_viscoelasticity_##which##_d_elastic,                   \
     form_viscoelasticity_##which##_m_rho,       form_viscoelasticity_##which##_a_young,                     \
     form_viscoelasticity_##which##_a_poisson,   form_viscoelasticity_##which##_b_kappa,                     \
     form_viscoelasticity_##which##_b_eta},                                                                  \
    {                                                                                                        \
      expression_viscoelasticity_##which##_strain, expression_viscoelasticity_##which##_stress,              \
          expression_viscoelasticity_##which##_von_mises                                                     \
    }                                                                                                        \
  }

Generated generated(int dim, int degree, scene::PlaneModel model) {
  using enum scene::PlaneModel;
  static const std::map<std::tuple<int, int, scene::PlaneModel>, Generated> all{
      {{2, 1, plane_strain}, SIGNORINI_GENERATED(triangle_1)},
      {{2, 2, plane_strain}, SIGNORINI_GENERATED(triangle_2)},
      {{2, 1, plane_stress}, SIGNORINI_GENERATED(triangle_1_plane_stress)},
      {{2, 2, plane_stress}, SIGNORINI_GENERATED(triangle_2_plane_stress)},
      {{2, 1, axisymmetric}, SIGNORINI_GENERATED(triangle_1_axisymmetric)},
      {{2, 2, axisymmetric}, SIGNORINI_GENERATED(triangle_2_axisymmetric)},
      {{3, 1, plane_strain}, SIGNORINI_GENERATED(tetrahedron_1)},
      {{3, 2, plane_strain}, SIGNORINI_GENERATED(tetrahedron_2)}};
  const auto found = all.find({dim, degree, model});
  if (found == all.end())
    throw std::logic_error("no forms were compiled for this cell, degree and model (CMakeLists.txt)");
  return found->second;
}

Generated generated(const Space& space) {
  return generated(space.dim(), space.degree(), space.mesh().model());
}

namespace {

/// Sets the elastic constants to those of the given moduli.
void set_moduli(scene::ElasticModuli moduli, ConstantValues& values) {
  values.young = moduli.young();
  values.poisson = moduli.poisson();
}

} // namespace

ConstantValues of_material(const scene::Material& material) {
  const scene::Viscosity viscosity = material.total_viscosity();
  ConstantValues values{.rho = material.density,
                        .young = material.young,
                        .poisson = material.poisson,
                        .kappa = viscosity.bulk,
                        .eta = viscosity.shear};
  if (material.relaxes())
    set_moduli(material.long_term(), values);
  return values;
}

ConstantValues of_step(const scene::Material& material, double tau) {
  ConstantValues values = of_material(material);
  values.tau = tau;
  if (material.relaxes())
    set_moduli(material.during_step(tau), values);
  return values;
}

ConstantValues of_moduli(const scene::Material& material, scene::ElasticModuli moduli) {
  // In plane stress the form b needs Poisson's ratio too: the strain out of the plane depends on it.
  return {.poisson = material.poisson, .kappa = moduli.bulk, .eta = moduli.shear};
}

Constants constants(const ConstantValues& values) {
  const auto constant = [](double value) {
    return std::make_shared<dolfinx::fem::Constant<PetscScalar>>(value);
  };
  return {{"rho", constant(values.rho)},           {"young", constant(values.young)},
          {"poisson", constant(values.poisson)},   {"kappa", constant(values.kappa)},
          {"eta", constant(values.eta)},           {"tau", constant(values.tau)},
          {"k_normal", constant(values.k_normal)}, {"k_tangential", constant(values.k_tangential)}};
}

Compiled compile(const Space& space, Form form, const std::vector<std::int32_t>& entities,
                 const ConstantValues& values) {
  using enum dolfinx::fem::IntegralType;
  const bool cellwise_trial = form == Form::L2_cellwise || form == Form::L2_cellwise_surface;
  const bool surface = form == Form::L2_surface || form == Form::L2_cellwise_surface || form == Form::springs;
  const auto type = surface ? exterior_facet : cell;
  const std::shared_ptr<const dolfinx::fem::FunctionSpace<double>> V = space.dolfinx();
  const ufcx_form& code = *generated(space).forms.at(static_cast<std::size_t>(form));
  // Check the generated code, since dolfinx leaves out integrals without entities.
  constexpr int types = 3; // cells, exterior and interior facets
  const int at = code.form_integral_offsets[static_cast<int>(type)];
  if (code.form_integral_offsets[types] != 1 || at != 0 ||
      code.form_integral_offsets[static_cast<int>(type) + 1] != 1 || code.form_integral_ids[at] != 1)
    throw std::runtime_error(
        "forms/viscoelasticity.py: a form must use the measure dx(1) alone, a form on a surface ds(1) alone");
  return dolfinx::fem::create_form<PetscScalar, double>(code,
                                                        {V, cellwise_trial ? cellwise(space.mesh()) : V}, {},
                                                        constants(values), {{type, {{1, entities}}}}, {});
}

} // namespace signorini::fem
