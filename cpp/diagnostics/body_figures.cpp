// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/body_figures.h"
#include "fem/coherence.h"
#include "fem/deformation.h"
#include "fem/sampler.h"
#include "fem/wave_time.h"
#include "step/functionals.h"
#include "trajectory/approach.h"
#include <algorithm>
#include <array>
#include <dolfinx/mesh/Mesh.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>

namespace signorini::diagnostics {

namespace {

/// Limits of wave speeds (m/s) and densities (kg/m³) of solids. No solid has faster waves than diamond, 18
/// km/s, or a higher density than osmium, 22,600 kg/m³. Solids from 2000 kg/m³ on are stones, glasses and
/// metals; lead has the slowest waves of these, 1.2 km/s.
constexpr double fastest = 20e3, densest = 25e3, heavy = 2000, slow_if_heavy = 100;
/// Lengths (m) above or below which a body is probably drawn in another unit.
constexpr double longest = 1000, shortest = 1e-5;
/// Largest plausible distance of an obstacle that the body does not reach, in lengths of the body.
constexpr double farthest = 10;

void warn_of_materials(const std::vector<scene::Material>& materials, scene::PlaneModel model,
                       std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const std::string key = materials.size() == 1 ? "material" : fmt::format("material[{}]", i);
    const double speed = fem::wave_speeds(materials[i], model)[0], density = materials[i].density;
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
                               ? "set mesh.unit = \"mm\" if the mesh is in millimetres"
                               : "set mesh.unit = \"m\" if the mesh is in metres";
  const double length = std::ranges::max(figures.extent);
  const bool waves_known = warnings.empty(); // times that follow from implausible speeds add nothing
  if (length > longest || length < shortest)
    warnings.push_back(fmt::format("the body is {:.3g} m long; {}", length, hint));
  else if (waves_known && time.end < figures.crossing)
    warnings.push_back(fmt::format("the run ends at {:.3g} s, before a wave has crossed the body of {:.3g} "
                                   "m, which takes {:.3g} s; {}. Moduli are in Pa",
                                   time.end, length, figures.crossing, hint));
  else if (waves_known && !time.automatic() && figures.crossing_steps < 1)
    warnings.push_back(fmt::format("in a step of {:.3g} s a wave crosses the body of {:.3g} m {:.3g} times; "
                                   "such steps resolve no waves, only slower motions",
                                   time.step, length, 1 / figures.crossing_steps));
  if (!stepper.pairs() || stepper.pairs()->moving() || stepper.operators().surrounded())
    return;
  const double gap = std::ranges::min(stepper.pairs()->psi());
  if (gap > farthest * length &&
      std::ranges::none_of(trajectory::first_touches(stepper, scene), &trajectory::FirstTouch::occurs))
    warnings.push_back(fmt::format(
        "the obstacle is {:.3g} m away from the body of {:.3g} m, which does not reach the obstacle until "
        "{:.3g} s; {}",
        gap, length, time.end, hint));
}

/// Adds a warning if more than half of the mesh's nodes are inside an obstacle. Nodes on the obstacle's
/// surface do not count, since the body may stand on it. A drop moves the body out before the motion starts.
void warn_of_normals(const step::Stepper& stepper, const scene::Scene& scene,
                     std::vector<std::string>& warnings) {
  if (scene.initial.drop)
    return;
  const contact::ContactPairs* pairs = stepper.pairs();
  const std::span<const double> x = stepper.space().mesh().dolfinx()->geometry().x();
  int next = 0; // obstacle
  for (int i = 0; pairs && i < pairs->count(); ++i) {
    const int number = pairs->obstacles()[i];
    if (number < next)
      continue;
    next = number + 1;
    const contact::Obstacle* obstacle = pairs->obstacle(i);
    if (!obstacle)
      continue;
    const contact::Obstacle::Place place = obstacle->place(0);
    std::array<std::int64_t, 2> nodes{0, static_cast<std::int64_t>(x.size() / 3)}; // inside, all
    for (std::size_t node = 0; 3 * node < x.size(); ++node)
      nodes[0] += obstacle->level(&x[3 * node], place) < -pairs->gap_tolerance();
    MPI_Allreduce(MPI_IN_PLACE, nodes.data(), 2, MPI_INT64_T, MPI_SUM, stepper.space().comm());
    if (2 * nodes[0] > nodes[1])
      warnings.push_back(fmt::format(
          "{}: {:.0f} % of the body is inside the obstacle; check that its normal points out of the obstacle",
          pairs->key(number), 100 * static_cast<double>(nodes[0]) / static_cast<double>(nodes[1])));
  }
}

/// Adds a note for each probe whose point is outside of the mesh by more than a tenth of an element, which is
/// more than elements along a curved surface leave out. Collective.
void note_outside(const step::Stepper& stepper, const scene::Scene& scene, std::vector<std::string>& notes) {
  std::vector<double> points;
  std::vector<std::string> names;
  for (const scene::Probe& probe : scene.output.probes)
    if (probe.point) {
      names.push_back(probe.name);
      points.insert(points.end(), probe.point->begin(), probe.point->end());
      points.resize(3 * names.size());
    }
  if (names.empty())
    return;
  constexpr double part = 0.1;
  const double most = part * fem::mean_diameter(stepper.space());
  const fem::Sampler sampler(stepper.space(), points);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (const double distance = sampler.distances()[i]; distance > most)
      notes.push_back(
          fmt::format("the probe \"{}\" is {:.3g} m outside of the body: its values are those of the "
                      "nearest element, continued",
                      names[i], distance));
}

/// Whether clamps hold the body sideways along most of its longest side, so that it cannot bend. Collective.
bool held_along(const step::Stepper& stepper, std::span<const double> extent) {
  constexpr int pieces = 10, most = 8;
  const fem::Space& space = stepper.space();
  const auto along = static_cast<std::size_t>(std::ranges::max_element(extent) - extent.begin());
  const std::vector<double>& x = space.points();
  double start = std::numeric_limits<double>::infinity();
  for (std::size_t i = along; i < x.size(); i += 3)
    start = std::min(start, x[i]);
  MPI_Allreduce(MPI_IN_PLACE, &start, 1, MPI_DOUBLE, MPI_MIN, space.comm());
  std::array<int, pieces> held{};
  for (std::size_t node = 0; 3 * node < x.size(); ++node)
    for (std::size_t c = 0; c < extent.size(); ++c)
      if (c != along && stepper.clamped().contains(static_cast<int>(node), static_cast<int>(c)))
        held[std::min<std::size_t>(
            pieces - 1, static_cast<std::size_t>(pieces * (x[3 * node + along] - start) / extent[along]))] =
            1;
  MPI_Allreduce(MPI_IN_PLACE, held.data(), pieces, MPI_INT, MPI_MAX, space.comm());
  return std::ranges::count(held, 1) >= most;
}

/// Adds a warning if a slender clamped body has few elements of degree 1 across: with four elements it is ten
/// per cent too stiff in bending, with fewer by a factor that depends on their shapes.
void warn_of_bending(const step::Stepper& stepper, const scene::Scene& scene, const BodyFigures& figures,
                     std::vector<std::string>& warnings) {
  constexpr double slender = 4, enough = 6;
  const std::span extent(figures.extent.data(), static_cast<std::size_t>(figures.dim));
  const auto [least, greatest] = std::ranges::minmax(extent);
  if (stepper.space().degree() > 1 || scene.clamps.empty() || !stepper.pairs() || greatest < slender * least)
    return;
  if (held_along(stepper, extent))
    return;
  const double across = least / fem::mean_diameter(stepper.space());
  if (across < enough)
    warnings.push_back(fmt::format(
        "elements of degree 1, of {:.3g} m on average, make the slender clamped body, {:.3g} m thick, too "
        "stiff in bending; set mesh.degree = 2",
        least / across, least));
}

} // namespace

BodyFigures body_figures(const step::Stepper& stepper, const scene::Scene& scene) {
  BodyFigures figures;
  figures.extent = stepper.space().mesh().extent();
  figures.dim = stepper.space().dim();
  figures.model = figures.dim == 3 ? "space" : scene::name(stepper.space().mesh().model());
  figures.per_depth = stepper.space().mesh().per_depth();
  figures.notes = stepper.space().mesh().notes();
  if (stepper.pairs() && stepper.pairs()->skips_axis())
    figures.notes.emplace_back(
        "the axis has no contact candidate: in degree 2 a pressure exerts no force on the node "
        "there");
  for (int i = 0; stepper.pairs() && i < stepper.pairs()->obstacle_count(); ++i)
    if (const contact::SurfacePair* surfaces = stepper.pairs()->surfaces(i);
        surfaces && surfaces->exchanged())
      figures.notes.push_back(fmt::format("{}: the candidates are nodes of the group \"{}\", whose facets "
                                          "are larger, since clamps hold nodes of "
                                          "the other group",
                                          stepper.pairs()->key(i),
                                          surfaces->slave_side() == scene::ContactSide::on
                                              ? scene.contacts[static_cast<std::size_t>(i)].on
                                              : *scene.contacts[static_cast<std::size_t>(i)].against));
  note_outside(stepper, scene, figures.notes);
  figures.mass = step::mean(stepper.space(), stepper.operators().M, 0).measure;
  std::vector<double> pressure, shear;
  for (const scene::Material& material : scene.materials) {
    const auto [fast, slow] = fem::wave_speeds(material, stepper.space().mesh().model());
    pressure.push_back(fast);
    shear.push_back(slow);
  }
  figures.pressure_waves = {std::ranges::min(pressure), std::ranges::max(pressure)};
  figures.shear_waves = {std::ranges::min(shear), std::ranges::max(shear)};
  figures.crossing = fem::crossing_time(stepper.space(), scene.materials);
  figures.crossing_steps = scene.time.automatic() ? 0 : figures.crossing / scene.time.step;
  warn_of_materials(scene.materials, stepper.space().mesh().model(), figures.warnings);
  warn_of_sizes(stepper, scene, figures, figures.warnings);
  warn_of_normals(stepper, scene, figures.warnings);
  warn_of_bending(stepper, scene, figures, figures.warnings);
  return figures;
}

std::string BodyFigures::line() const {
  std::vector<std::string> sides;
  for (int c = 0; c < dim; ++c)
    sides.push_back(fmt::format("{:.3g}", extent[c]));
  const auto speeds = [](const std::array<double, 2>& range) {
    return range[0] == range[1] ? fmt::format("{:.3g}", range[0])
                                : fmt::format("{:.3g} to {:.3g}", range[0], range[1]);
  };
  const std::string stands_for = model == "axisymmetric"   ? " in the half section of a body of revolution"
                                 : model == "plane-stress" ? " in plane stress"
                                                           : "";
  return fmt::format("body: {} m{}, {:.3g} kg{}; pressure waves {} m/s, shear waves {} m/s; a pressure wave "
                     "crosses the body in {:.2e} s{}",
                     fmt::join(sides, " x "), stands_for, mass, per_depth, speeds(pressure_waves),
                     speeds(shear_waves), crossing,
                     crossing_steps > 0 ? fmt::format(" ({:.3g} steps)", crossing_steps) : "");
}

} // namespace signorini::diagnostics
