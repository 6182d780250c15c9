// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/body_figures.h"
#include "fem/deformation.h"
#include "fem/wave_time.h"
#include "trajectory/approach.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/mesh/Mesh.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini::diagnostics {
using petsc::check;

namespace {

/// No solid has faster waves than diamond, 18 km/s, or more mass than osmium, 22,600 kg/m³; and those from
/// 2000 kg/m³ on are stones, glasses and metals, of which lead has the slowest, at 1.2 km/s.
constexpr double fastest = 20e3, densest = 25e3, heavy = 2000, slow_if_heavy = 100;
/// Beyond these a body is drawn in another unit more likely than not, m.
constexpr double longest = 1000, shortest = 1e-5;
/// Times of the body that an obstacle may be away if the body does not fly there.
constexpr double farthest = 10;

double mass(const step::Stepper& stepper) {
  const petsc::Vector along_x = stepper.space().vector(), image = petsc::zero_like(along_x);
  {
    const petsc::WriteArray values(along_x);
    for (std::size_t i = 0; i < values.size(); i += static_cast<std::size_t>(stepper.space().dim()))
      values[i] = 1;
  }
  check(MatMult(stepper.operators().M, along_x, image));
  return petsc::dot(along_x, image);
}

void warn_of_materials(const std::vector<scene::Material>& materials, std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const std::string key = materials.size() == 1 ? "material" : fmt::format("material[{}]", i);
    const double speed = fem::wave_speeds(materials[i])[0], density = materials[i].density;
    if (density > densest)
      warnings.push_back(
          fmt::format("{}.density is {:.4g} kg/m³, more than that of any solid", key, density));
    else if (speed > fastest)
      warnings.push_back(
          fmt::format("{}: waves of {:.3g} m/s are faster than in any solid; young is in Pa, density "
                      "in kg/m³",
                      key, speed));
    else if (density >= heavy && speed < slow_if_heavy)
      warnings.push_back(
          fmt::format("{}: waves of {:.3g} m/s are slower than in any solid of {:.4g} kg/m³; young is "
                      "in Pa, density in kg/m³",
                      key, speed, density));
  }
}

void warn_of_sizes(const step::Stepper& stepper, const scene::Scene& scene, const BodyFigures& figures,
                   std::vector<std::string>& warnings) {
  const scene::Time& time = scene.time;
  const char* const hint = scene.mesh.unit == scene::LengthUnit::m
                               ? "mesh.unit = \"mm\" takes a mesh in millimetres"
                               : "mesh.unit = \"m\" takes a mesh in metres";
  const double length = std::ranges::max(figures.extent);
  const bool waves_known = warnings.empty(); // times that follow from doubtful speeds say nothing more
  if (length > longest || length < shortest)
    warnings.push_back(fmt::format("the body is {:.3g} m long; {}", length, hint));
  else if (waves_known && time.end < figures.crossing)
    warnings.push_back(
        fmt::format("the run ends at {:.3g} s, before a wave has come across the body of {:.3g} m, which "
                    "takes {:.3g} s; {}, and moduli are in Pa",
                    time.end, length, figures.crossing, hint));
  else if (waves_known && !time.automatic() && figures.crossing_steps < 1)
    warnings.push_back(
        fmt::format("a step takes {:.3g} s, in which a wave comes {:.3g} times across the body of {:.3g} "
                    "m: only motions slower than that are resolved",
                    time.step, 1 / figures.crossing_steps, length));
  if (!stepper.pairs() || stepper.pairs()->moving())
    return;
  const double gap = std::ranges::min(stepper.pairs()->psi());
  if (gap > farthest * length &&
      std::ranges::none_of(trajectory::first_touches(stepper, scene), &trajectory::FirstTouch::occurs))
    warnings.push_back(fmt::format(
        "the obstacle is {:.3g} m away from a body of {:.3g} m, which its initial velocity and the loads do "
        "not bring there before {:.3g} s; {}",
        gap, length, time.end, hint));
}

/// A body that is inside of an obstacle but for its surface, which may stand on it.
void warn_of_normals(const step::Stepper& stepper, std::vector<std::string>& warnings) {
  const contact::ContactPairs* pairs = stepper.pairs();
  const std::span<const double> x = stepper.space().mesh().dolfinx()->geometry().x();
  int next = 0; // obstacle
  for (int i = 0; pairs && i < pairs->count(); ++i) {
    const int number = pairs->obstacles()[static_cast<std::size_t>(i)];
    if (number < next)
      continue;
    next = number + 1;
    const contact::Obstacle& obstacle = pairs->obstacle(i);
    const contact::Obstacle::Place place = obstacle.place(0);
    std::array<std::int64_t, 2> nodes{0, static_cast<std::int64_t>(x.size() / 3)}; // inside, all
    for (std::size_t node = 0; 3 * node < x.size(); ++node)
      nodes[0] += obstacle.level(&x[3 * node], place) < -pairs->gap_tolerance();
    MPI_Allreduce(MPI_IN_PLACE, nodes.data(), 2, MPI_INT64_T, MPI_SUM, stepper.space().comm());
    if (2 * nodes[0] > nodes[1])
      warnings.push_back(fmt::format(
          "{}: {:.0f} % of the body is inside the obstacle, whose normal points out of "
          "it and may be reversed",
          pairs->key(number), 100 * static_cast<double>(nodes[0]) / static_cast<double>(nodes[1])));
  }
}

/// Elements of degree 1 are too stiff in bending, by ten per cent with four across the height.
void warn_of_bending(const step::Stepper& stepper, const scene::Scene& scene, const BodyFigures& figures,
                     std::vector<std::string>& warnings) {
  constexpr double slender = 4, enough = 6;
  const std::span extent(figures.extent.data(), static_cast<std::size_t>(figures.dim));
  const auto [least, greatest] = std::ranges::minmax(extent);
  if (stepper.space().degree() > 1 || scene.clamps.empty() || !stepper.pairs() || greatest < slender * least)
    return;
  const double across = least / fem::mean_diameter(stepper.space());
  if (across < enough)
    warnings.push_back(
        fmt::format("a slender body that is held has elements of degree 1, {:.2g} across, which are too "
                    "stiff in bending by ten per cent or more; mesh.degree = 2 is not",
                    across));
}

} // namespace

BodyFigures body_figures(const step::Stepper& stepper, const scene::Scene& scene) {
  BodyFigures figures;
  figures.extent = stepper.space().mesh().extent();
  figures.dim = stepper.space().dim();
  figures.notes = stepper.space().mesh().notes();
  figures.mass = mass(stepper);
  std::vector<double> pressure, shear;
  for (const scene::Material& material : scene.materials) {
    pressure.push_back(fem::wave_speeds(material)[0]);
    shear.push_back(fem::wave_speeds(material)[1]);
  }
  figures.pressure_waves = {std::ranges::min(pressure), std::ranges::max(pressure)};
  figures.shear_waves = {std::ranges::min(shear), std::ranges::max(shear)};
  figures.crossing = fem::crossing_time(stepper.space(), scene.materials);
  figures.crossing_steps = scene.time.automatic() ? 0 : figures.crossing / scene.time.step;
  warn_of_materials(scene.materials, figures.warnings);
  warn_of_sizes(stepper, scene, figures, figures.warnings);
  warn_of_normals(stepper, figures.warnings);
  warn_of_bending(stepper, scene, figures, figures.warnings);
  return figures;
}

std::string BodyFigures::line() const {
  std::vector<std::string> sides;
  for (int c = 0; c < dim; ++c)
    sides.push_back(fmt::format("{:.3g}", extent[static_cast<std::size_t>(c)]));
  const auto speeds = [](const std::array<double, 2>& range) {
    return range[0] == range[1] ? fmt::format("{:.3g}", range[0])
                                : fmt::format("{:.3g} to {:.3g}", range[0], range[1]);
  };
  return fmt::format(
      "body: {} m, {:.3g} kg{}; pressure waves {} m/s, shear waves {} m/s, across it in {:.2e} s{}",
      fmt::join(sides, " x "), mass, dim == 2 ? "/m" : "", speeds(pressure_waves), speeds(shear_waves),
      crossing, crossing_steps > 0 ? fmt::format(", {:.3g} steps", crossing_steps) : "");
}

} // namespace signorini::diagnostics
