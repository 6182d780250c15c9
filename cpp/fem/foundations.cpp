// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/foundations.h"
#include "base/error.h"
#include "fem/coherence.h"
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
Springs impedances(const scene::Material& material) {
  const auto [pressure, shear] = wave_speeds(material);
  return {material.density * pressure, material.density * shear};
}

/// Derivatives of impedances() by a constant of the material.
Springs impedance_rates(const scene::Material& material, scene::Parameter of) {
  const Springs now = impedances(material);
  const double nu = material.poisson;
  const auto scaled = [&](double normal, double tangential) {
    return Springs{now.normal * normal, now.tangential * tangential};
  };
  switch (of) {
  case scene::Parameter::density:
    return scaled(1 / (2 * material.density), 1 / (2 * material.density));
  case scene::Parameter::young:
    return scaled(1 / (2 * material.young), 1 / (2 * material.young));
  case scene::Parameter::poisson: // half the logarithmic derivatives of the moduli
    return scaled((-1 / (1 - nu) - 1 / (1 + nu) + 2 / (1 - 2 * nu)) / 2, -1 / (2 * (1 + nu)));
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
  add_absorbing(space, foundations, materials, [&](std::size_t p) { return impedances(materials[p]); }, all);
  return assembled(space, all);
}

petsc::Matrix assemble_foundation_rate(const Space& space, const std::vector<scene::Foundation>& foundations,
                                       std::size_t number, bool normal) {
  return assemble_springs(space, {on_facets(space, foundations, number, normal ? 1 : 0, normal ? 0 : 1)});
}

petsc::Matrix assemble_absorption_rate(const Space& space, const std::vector<scene::Foundation>& foundations,
                                       const std::vector<scene::Material>& materials, std::size_t material,
                                       scene::Parameter of) {
  std::vector<Springs> all;
  add_absorbing(
      space, foundations, materials,
      [&](std::size_t p) { return p == material ? impedance_rates(materials[p], of) : Springs{}; }, all);
  return assembled(space, all);
}

} // namespace signorini::fem
