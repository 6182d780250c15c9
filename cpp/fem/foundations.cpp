// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/foundations.h"
#include "base/error.h"
#include "fem/surface.h"
#include "fem/wave_time.h"
#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

namespace signorini::fem {

namespace {

std::string key_of(std::size_t i) { return scene::foundation_key(i) + ".on"; }

/// Returns the springs or dashpots on the facets of the foundation `i`.
Springs on_facets(const Space& space, const std::vector<scene::Foundation>& foundations, std::size_t i,
                  double normal, double tangential) {
  return {normal, tangential, sides(space, foundations[i].on, key_of(i))};
}

/// Dashpots that absorb plane waves along the normal: impedances ρ c of pressure and shear waves.
Springs impedances(const scene::Material& material, scene::PlaneModel model) {
  const auto [pressure, shear] = wave_speeds(material, model);
  return {material.density * pressure, material.density * shear};
}

/// Whether impedances() depend on a constant of the material. On fractions of a Prony series they depend only
/// if the long-term moduli are given, from which the instantaneous ones follow.
bool impedances_depend_on(scene::Parameter of, const scene::Material& material) {
  switch (of) {
  case scene::Parameter::density:
  case scene::Parameter::young:
  case scene::Parameter::poisson:
    return true;
  case scene::Parameter::prony_g:
  case scene::Parameter::prony_k:
    return material.moduli == scene::Moduli::long_term;
  default:
    return false;
  }
}

/// Derivatives of impedances() by a constant of the material.
Springs impedance_rates(const scene::Material& material, scene::PlaneModel model, scene::Parameter of) {
  const Springs now = impedances(material, model);
  const double nu = material.poisson;
  const auto scaled = [&](double normal, double tangential) {
    return Springs{now.normal * normal, now.tangential * tangential};
  };
  // By the logarithmic derivatives of K_0 and G_0, since (ρ c_p)² = ρ (K_0 + 4/3 G_0) and (ρ c_s)² = ρ G_0.
  const auto by_moduli = [&](double bulk, double shear) {
    const auto [K, G] = material.instantaneous();
    const double part = K / (K + 4.0 / 3 * G);
    return scaled((part * bulk + (1 - part) * shear) / 2, shear / 2);
  };
  const scene::ElasticModuli given = material.given();
  switch (of) {
  case scene::Parameter::density:
    return scaled(1 / (2 * material.density), 1 / (2 * material.density));
  case scene::Parameter::young:
    return scaled(1 / (2 * material.young), 1 / (2 * material.young));
  case scene::Parameter::poisson:
    if (material.moduli == scene::Moduli::long_term)
      return by_moduli(2 / (1 - 2 * nu), -1 / (1 + nu));
    // Half the logarithmic derivatives of the moduli.
    if (model == scene::PlaneModel::plane_stress)
      return scaled(nu / (1 - nu * nu), -1 / (2 * (1 + nu)));
    return scaled((-1 / (1 - nu) - 1 / (1 + nu) + 2 / (1 - 2 * nu)) / 2, -1 / (2 * (1 + nu)));
  case scene::Parameter::prony_k: // K_0 = K / (1 − Σk)
    return by_moduli(material.instantaneous().bulk / given.bulk, 0);
  case scene::Parameter::prony_g:
    return by_moduli(0, material.instantaneous().shear / given.shear);
  default:
    throw std::logic_error("impedances do not depend on this parameter");
  }
}

/// Throws UserError unless all facets of an absorbing foundation are on the boundary. Collective.
void require_boundary(const mesh::Mesh& mesh, const std::string& group, const std::string& key) {
  if (inner_facets(mesh, group, key) > 0)
    throw UserError(fmt::format("{}: found \"{}\", which has facets inside the body; an absorbing foundation "
                                "needs a part of the boundary",
                                key, group));
}

/// Returns the facets at cells that are in `cells`, ascending.
std::vector<std::int32_t> at_cells(const std::vector<std::int32_t>& facets,
                                   const std::vector<std::int32_t>& cells) {
  std::vector<std::int32_t> at;
  for (std::size_t i = 0; i < facets.size(); i += 2)
    if (std::ranges::binary_search(cells, facets[i]))
      at.insert(at.end(), {facets[i], facets[i + 1]});
  return at;
}

/// Appends `dashpots` of each material, on the facets of absorbing foundations at its cells.
template <class Dashpots>
void add_absorbing(const Space& space, const std::vector<scene::Foundation>& foundations,
                   const std::vector<scene::Material>& materials, const Dashpots& dashpots,
                   std::vector<Springs>& all) {
  if (std::ranges::none_of(foundations, &scene::Foundation::absorbing))
    return;
  const std::vector<Part> body = parts(space.mesh(), materials);
  for (std::size_t i = 0; i < foundations.size(); ++i) {
    if (!foundations[i].absorbing)
      continue;
    const std::vector<std::int32_t> facets = sides(space, foundations[i].on, key_of(i));
    require_boundary(space.mesh(), foundations[i].on, key_of(i));
    for (std::size_t p = 0; p < body.size(); ++p) {
      std::vector<std::int32_t> cells = body[p].cells;
      std::ranges::sort(cells);
      Springs made = dashpots(p);
      made.facets = at_cells(facets, cells);
      all.push_back(std::move(made));
    }
  }
}

petsc::Matrix assembled(const Space& space, const std::vector<Springs>& surfaces) {
  return surfaces.empty() ? petsc::Matrix() : assemble_springs(space, surfaces);
}

} // namespace

petsc::Matrix assemble_springs(const Space& space, const std::vector<scene::Foundation>& foundations) {
  std::vector<Springs> all;
  for (std::size_t i = 0; i < foundations.size(); ++i)
    if (const auto& springs = foundations[i].stiffness)
      all.push_back(on_facets(space, foundations, i, springs->normal, springs->tangential));
  return assembled(space, all);
}

petsc::Matrix assemble_dashpots(const Space& space, const std::vector<scene::Foundation>& foundations,
                                const std::vector<scene::Material>& materials) {
  std::vector<Springs> all;
  for (std::size_t i = 0; i < foundations.size(); ++i)
    if (const auto& dashpots = foundations[i].damping)
      all.push_back(on_facets(space, foundations, i, dashpots->normal, dashpots->tangential));
  add_absorbing(
      space, foundations, materials,
      [&](std::size_t p) { return impedances(materials[p], space.mesh().model()); }, all);
  return assembled(space, all);
}

petsc::Matrix assemble_foundation_rate(const Space& space, const std::vector<scene::Foundation>& foundations,
                                       std::size_t number, bool normal) {
  return assemble_springs(space, {on_facets(space, foundations, number, normal ? 1 : 0, normal ? 0 : 1)});
}

petsc::Matrix assemble_absorption_rate(const Space& space, const std::vector<scene::Foundation>& foundations,
                                       const std::vector<scene::Material>& materials, std::size_t material,
                                       scene::Parameter of) {
  if (!impedances_depend_on(of, materials[material]))
    return {};
  std::vector<Springs> all;
  add_absorbing(
      space, foundations, materials,
      [&](std::size_t p) {
        return p == material ? impedance_rates(materials[p], space.mesh().model(), of) : Springs{};
      },
      all);
  return assembled(space, all);
}

} // namespace signorini::fem
