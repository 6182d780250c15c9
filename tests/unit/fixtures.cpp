// SPDX-License-Identifier: GPL-3.0-or-later
#include "fixtures.h"
#include <map>
#include <tuple>

namespace signorini::test {
namespace {

using Group = std::optional<std::string>;
using Key = std::tuple<std::filesystem::path, std::optional<double>, double, scene::LengthUnit, int,
                       std::optional<scene::PlaneModel>, Group, Group>;

std::map<Key, std::shared_ptr<const problem::SpaceDiscretisation>> discretisations;

} // namespace

std::shared_ptr<const problem::SpaceDiscretisation> discretised(const scene::Scene& scene) {
  const scene::Mesh& mesh = scene.mesh;
  const auto make = [&] {
    Timers timers;
    return std::make_shared<const problem::SpaceDiscretisation>(MPI_COMM_WORLD, scene, timers);
  };
  if (!mesh.file.string().starts_with(
          source("").string())) // another test may write another file of that name
    return make();
  auto& shared = discretisations[{mesh.file, mesh.size, mesh.scale, mesh.unit, mesh.degree, mesh.model,
                                  scene.control ? scene.control->on : Group(),
                                  scene.objective ? scene.objective->on : Group()}];
  if (!shared)
    shared = make();
  return shared;
}

void forget_discretisations() { discretisations.clear(); }

} // namespace signorini::test
