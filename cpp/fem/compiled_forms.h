// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/forms.h"
#include <array>
#include <dolfinx/fem/Constant.h>
#include <dolfinx/fem/Form.h>
#include <map>
#include <memory>
#include <string>
#include <vector>

struct ufcx_form;
struct ufcx_expression;

/// Forms and fields of forms/viscoelasticity.py as generated code, for use within fem. Only
/// compiled_forms.cpp includes that code.
namespace signorini::fem {

/// Returns the name of a form in forms/viscoelasticity.py.
const char* name(Form form);

/// Generated code of all forms, in the order of enum Form, and of all fields, in the order of enum CellField.
struct Generated {
  std::array<const ufcx_form*, 15> forms;
  std::array<const ufcx_expression*, 3> fields;
};

/// Returns the generated code for simplices of dimension `dim`, functions of degree `degree` and, in the
/// plane, `model`. Throws std::logic_error if none was compiled for these.
Generated generated(int dim, int degree, scene::PlaneModel model);
/// Returns the generated code for the functions of a space.
Generated generated(const Space& space);

/// Values of the constants of forms and fields, by their names in forms/viscoelasticity.py.
struct ConstantValues {
  double rho = 0;                        ///< density, kg/m³
  double young = 0, poisson = 0;         ///< Young's modulus, Pa; Poisson's ratio
  double kappa = 0, eta = 0;             ///< viscosities, Pa s; moduli, Pa, in forms of a displacement
  double tau = 0;                        ///< length of a step, s
  double k_normal = 0, k_tangential = 0; ///< springs, N/m³; dashpots, N s/m³
};

/// Returns the values of a material. If it relaxes, its elastic constants are those after relaxation.
ConstantValues of_material(const scene::Material& material);
/// Returns the values of a material in a step of length `tau`, s. If it relaxes, its elastic constants are
/// those of Material::during_step().
ConstantValues of_step(const scene::Material& material, double tau);
/// Returns values with which the form b, or the stress of a velocity, is that of an elastic material with the
/// given moduli, if a displacement takes the place of the velocity. In plane stress the moduli must have the
/// ratio of those of `material`.
ConstantValues of_moduli(const scene::Material& material, scene::ElasticModuli moduli);

using Constants = std::map<std::string, std::shared_ptr<const dolfinx::fem::Constant<PetscScalar>>>;
/// Returns the constants that compiled forms and fields take.
Constants constants(const ConstantValues& values);

using Compiled = dolfinx::fem::Form<PetscScalar, double>;
/// Compiles a form over `entities`: cells, or facets given as pairs of a cell and the facet's number in this
/// cell. Throws std::runtime_error if the form has a constant that the program does not provide, or has a
/// measure other than dx(1) or, on a surface, ds(1).
Compiled compile(const Space& space, Form form, const std::vector<std::int32_t>& entities,
                 const ConstantValues& values);

} // namespace signorini::fem
