// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/plausibility.h"
#include "base/collective.h"
#include "base/error.h"
#include "fem/coherence.h"
#include "fem/deformation.h"
#include "fem/surface.h"
#include "fem/wave_time.h"
#include "step/functionals.h"
#include "step/point_force.h"
#include "trajectory/approach.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/mesh/Mesh.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numbers>
#include <numeric>

namespace signorini::diagnostics {
using petsc::check;

namespace {

/// Limit of strain. Small strain neglects ε²/2 of a stretch ε, at this limit a fortieth of ε.
constexpr double small_strain = 0.05;
/// Limit of rotation, radians. In small strain a rotation by θ stretches the body by θ²/2, at this limit by
/// 0.4 per cent, as much as a strong load stretches a stiff body.
constexpr double small_rotation = 5 * std::numbers::pi / 180;
/// Limit of the error of a linearised gap, relative to the node's displacement; the same as that of strain.
constexpr double small_gap_error = 0.05;

/// Limit of the depth of a node on the axis without candidate inside an obstacle, relative to the body's
/// diameter.
constexpr double shallow = 1e-3;

double degrees(double angle) { return angle * 180 / std::numbers::pi; }

/// Returns a value above a limit as text, with four digits or as many as show that it is above the limit.
std::string above(double value, double limit) {
  int digits = 4;
  std::string text = fmt::format("{:.{}g}", value, digits);
  while (!(std::stod(text) > limit) && digits < std::numeric_limits<double>::max_digits10)
    text = fmt::format("{:.{}g}", value, ++digits);
  return text;
}

/// A value, a second figure and a place (3); rows are ordered by the value.
using Row = std::array<double, 5>;
/// Returns the largest of all ranks' rows. Collective.
Row largest(MPI_Comm comm, const Row& mine) {
  const std::vector<Row> all = gather(comm, std::vector<Row>{mine});
  return *std::ranges::max_element(all);
}

} // namespace

Plausibility::Plausibility(const step::Stepper& stepper, const scene::Scene& scene)
    : stepper_(stepper), scene_(scene), largest_energy_state_(stepper.space().vector()),
      gaps_(stepper.rows()) {
  if (stepper.pairs())
    psi_ = stepper.pairs()->gaps();
}

void Plausibility::observe(const trajectory::Frame& frame, const StepBalance* balance) {
  if (balance && balance->elastic_energy > energy_) {
    energy_ = balance->elastic_energy;
    check(VecCopy(frame.after.y(), largest_energy_state_));
    largest_energy_time_ = frame.step.end;
  }
  constexpr double rounding = 1e-9;
  const int part = static_cast<int>(checked_frames * frame.step.end / stepper_.end() + rounding) + 1;
  if (part > checked_parts_ || frame.last) {
    checked_parts_ = part;
    check_displacement(frame.after.y(), frame.step.end);
  }
}

void Plausibility::check_displacement(Vec y, double t) {
  const fem::Deformation now = fem::deformation(stepper_.space(), y);
  const auto take = [t](Worst& worst, double value, const std::array<double, 3>& at, double limit) {
    if (value > limit)
      worst.passed = std::min(worst.passed, t);
    if (value > (1 + fem::tie) * worst.value) // of frames that are equal but for rounding, the first
      worst = {value, t, at, worst.passed};
  };
  take(strain_, now.strain.value, now.strain.at, small_strain);
  take(rotation_, now.rotation.value, now.rotation.at, small_rotation);
  take(inverted_, static_cast<double>(now.inverted), {}, 0);
  if (stepper_.pairs())
    check_contact(y, t);
}

void Plausibility::check_contact(Vec y, double t) {
  const contact::ContactPairs& pairs = *stepper_.pairs();
  if (pairs.skips_axis())
    if (const contact::ContactPairs::Depth there = pairs.deepest_on_axis(y, t); there.depth > axis_.value)
      axis_ = {there.depth, t, there.x, t};
  pairs.rows().gap(pairs.psi(t, *psi_), y, gaps_);
  const auto dim = static_cast<std::size_t>(pairs.dim());
  std::vector<contact::RigidMotion::Place> moved_by_mass(static_cast<std::size_t>(pairs.obstacle_count()));
  for (int i = 0; i < pairs.obstacle_count(); ++i)
    if (const contact::RigidMotion* rigid = pairs.rigid(i)) {
      contact::RigidMotion::Place& place = moved_by_mass[static_cast<std::size_t>(i)] = rigid->place(y);
      if (const double turned = std::hypot(place.rotation[0], place.rotation[1], place.rotation[2]);
          turned > obstacle_turn_.value)
        obstacle_turn_ = {turned, t, rigid->center(), t};
    }
  Row slip{}, gap{};
  {
    const petsc::ReadArray values(y);
    const std::span<const double> all = values;
    for (int i = 0; i < pairs.count(); ++i) {
      const double* moved = pairs.displacement(i, all);
      const contact::Obstacle* obstacle = pairs.obstacle(i);
      if (!moved || !obstacle || !obstacle->curved())
        continue;
      const auto candidate = static_cast<std::size_t>(i);
      const double* x = &pairs.points()[3 * candidate];
      const double* nu = &pairs.normals()[dim * candidate];
      std::array<double, 3> place{x[0], x[1], x[2]}, way{}; // relative to an obstacle with mass
      std::copy_n(moved, dim, way.begin());
      const auto number = static_cast<std::size_t>(pairs.obstacles()[candidate]);
      if (const contact::RigidMotion* rigid = pairs.rigid(static_cast<int>(number))) {
        const std::array<double, 3> of_obstacle = rigid->displacement(moved_by_mass[number], x);
        for (std::size_t c = 0; c < dim; ++c)
          way[c] -= of_obstacle[c];
      }
      for (std::size_t c = 0; c < dim; ++c)
        place[c] += way[c];
      const double square = std::inner_product(way.begin(), way.end(), way.begin(), 0.0);
      double distance = 0;
      const contact::Obstacle::Place& now = psi_->place[number];
      try {
        distance = obstacle->at(place.data(), now).height;
      } catch (const UserError&) { // no direction leads out of the obstacle: the node is deep inside
        distance = gaps_[candidate] - std::sqrt(square);
      }
      // Where neither distance shows contact, their difference has no effect.
      if (std::min(gaps_[candidate], distance) > pairs.gap_tolerance())
        continue;
      const std::array<double, 3> r = obstacle->from_middle(place.data(), now);
      const double normal = std::inner_product(nu, nu + dim, r.begin(), 0.0),
                   along = std::sqrt(std::max(0.0, std::inner_product(r.begin(), r.end(), r.begin(), 0.0) -
                                                       normal * normal)),
                   error = std::abs(distance - gaps_[candidate]);
      slip = std::max(slip, Row{along / now.radius, along, x[0], x[1], x[2]});
      if (error > pairs.gap_tolerance())
        gap = std::max(gap, Row{error / std::sqrt(square), error, x[0], x[1], x[2]});
    }
  }
  const auto take = [&](Worst& worst, Row row) {
    row = largest(stepper_.space().comm(), row);
    if (row[0] > worst.value)
      worst = {row[0], t, {row[2], row[3], row[4]}, worst.passed};
  };
  take(slip_, slip);
  take(gap_, gap);
}

std::string Plausibility::where(const Worst& worst) const {
  return fmt::format("at ({:.6g}) m, t = {:.6g} s",
                     fmt::join(worst.at.begin(), worst.at.begin() + stepper_.space().dim(), ", "),
                     worst.time);
}

std::string Plausibility::since(const Worst& worst) {
  return fmt::format("(the limit is first exceeded at or before t = {:.6g} s)", worst.passed);
}

int Plausibility::forces_on_clamps() const {
  const fem::Space& space = stepper_.space();
  int count = 0;
  for (std::size_t i = 0; i < scene_.load->points.size(); ++i) {
    const scene::PointForce& force = scene_.load->points[i];
    const std::optional<std::size_t> node = step::node_at(space, force.at, fmt::format("load.point[{}]", i));
    if (!node)
      continue;
    bool held = true;
    for (std::size_t c = 0; c < force.value.size(); ++c)
      held = held && (scene::vanishes({force.value[c]}) ||
                      stepper_.clamped().contains(static_cast<int>(*node), static_cast<int>(c)));
    count += held;
  }
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT, MPI_SUM, space.comm());
  return count;
}

void Plausibility::add_of_mesh(std::vector<Warning>& warnings) const {
  const fem::Space& space = stepper_.space();
  const int parts = fem::connected_parts(space).count;
  const auto pairs = std::ranges::count_if(scene_.contacts,
                                           [](const scene::Contact& one) { return one.against.has_value(); });
  if (parts > 1 + pairs) // fewer contacts than would connect all parts
    warnings.push_back(
        {"parts of the mesh",
         fmt::format("the mesh consists of {} parts that share no node; each part moves independently of the "
                     "others",
                     parts),
         static_cast<double>(parts), 1});
  if (const std::size_t points = scene_.load ? scene_.load->points.size() : 0; points > 0) {
    const int held = forces_on_clamps();
    warnings.push_back(
        {"force at a point",
         fmt::format("{} force{} at single nodes: the displacement there grows without limit as "
                     "the mesh is refined{}",
                     points, points == 1 ? "" : "s",
                     held > 0 ? fmt::format(". Of these, {} act on clamps alone, without effect", held) : ""),
         static_cast<double>(points), 0});
  }
  for (std::size_t i = 0; i < scene_.contacts.size(); ++i) {
    const std::string key = scene::contact_key(scene_.contacts, i), &group = scene_.contacts[i].on;
    const auto add = [&](const char* name, std::int64_t facets, const char* what) {
      if (facets > 0)
        warnings.push_back({name,
                            fmt::format("{}.on: the group \"{}\" has {} facet{} {}", key, group, facets,
                                        facets == 1 ? "" : "s", what),
                            static_cast<double>(facets), 0});
    };
    add("contact inside the body", fem::inner_facets(space.mesh(), group, key + ".on"),
        "inside the body, out of reach of any obstacle");
    add("contact on a clamp",
        fem::facets_among(space, group, key + ".on", stepper_.pairs()->clamped_dofs(static_cast<int>(i))),
        "that cannot come into contact, since all nodes there are clamped");
  }
}

std::vector<Warning> Plausibility::warnings() {
  if (largest_energy_time_ >= 0)
    check_displacement(largest_energy_state_, std::exchange(largest_energy_time_, -1));
  std::vector<Warning> found;
  add_of_mesh(found);
  if (strain_.value > small_strain)
    found.push_back(
        {"large strain",
         fmt::format("a principal strain is {} {}; the small-strain model is meant for strains below {} {}",
                     above(strain_.value, small_strain), where(strain_), small_strain, since(strain_)),
         strain_.value, small_strain});
  if (rotation_.value > small_rotation)
    found.push_back(
        {"large rotation",
         fmt::format("the body turns by {} degrees {}; the small-strain model is meant for rotations below "
                     "{:.3g} degrees {}",
                     above(degrees(rotation_.value), degrees(small_rotation)), where(rotation_),
                     degrees(small_rotation), since(rotation_)),
         degrees(rotation_.value), degrees(small_rotation)});
  if (obstacle_turn_.value > small_rotation)
    found.push_back(
        {"large rotation",
         fmt::format("the obstacle with mass {} turns by {} degrees; its motion is meant for small "
                     "angles, below {:.3g} degrees",
                     where(obstacle_turn_), above(degrees(obstacle_turn_.value), degrees(small_rotation)),
                     degrees(small_rotation)),
         degrees(obstacle_turn_.value), degrees(small_rotation)});
  const auto rings = [](const scene::Contact& one) {
    return one.massless() && one.rigid && one.rigid->mass > 0;
  };
  if (std::ranges::any_of(scene_.contacts, rings))
    found.push_back({"massless contact with a mass",
                     "contact.mass: surfaces without mass ring against an obstacle with mass, so that forces "
                     "alternate; set it to \"consistent\" and time.scheme to \"contact-stabilized\"",
                     1, 0});
  if (inverted_.value > 0)
    found.push_back(
        {"elements turned inside out",
         fmt::format("{} elements are turned inside out at t = {:.6g} s", inverted_.value, inverted_.time),
         inverted_.value, 0});
  if (slip_.value > 1)
    found.push_back({"motion beyond an obstacle's radius",
                     fmt::format("the node {} slid {} obstacle radii along the obstacle; its contact plane "
                                 "is still the tangent plane at its undeformed position",
                                 where(slip_), above(slip_.value, 1)),
                     slip_.value, 1});
  if (const double limit = shallow * stepper_.space().mesh().diameter(); axis_.value > limit)
    found.push_back(
        {"axis inside an obstacle",
         fmt::format("the node {} on the axis is {} m inside an obstacle: in degree 2 it is no contact "
                     "candidate. Use mesh.degree = 1 for bodies with a tip on the axis",
                     where(axis_), above(axis_.value, limit)),
         axis_.value, limit});
  if (gap_.value > small_gap_error)
    found.push_back({"linearised gap",
                     fmt::format("the gap of the node {} has an error of {} of the node's displacement "
                                 "(limit {}): the obstacle is linearised about the undeformed body",
                                 where(gap_), above(gap_.value, small_gap_error), small_gap_error),
                     gap_.value, small_gap_error});
  return found;
}

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
/// surface do not count, since the body may stand on it.
void warn_of_normals(const step::Stepper& stepper, std::vector<std::string>& warnings) {
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

/// Adds a warning if a slender clamped body has few elements of degree 1 across: with four elements it is ten
/// per cent too stiff in bending.
void warn_of_bending(const step::Stepper& stepper, const scene::Scene& scene, const BodyFigures& figures,
                     std::vector<std::string>& warnings) {
  constexpr double slender = 4, enough = 6, percent_at_four = 10;
  const std::span extent(figures.extent.data(), static_cast<std::size_t>(figures.dim));
  const auto [least, greatest] = std::ranges::minmax(extent);
  if (stepper.space().degree() > 1 || scene.clamps.empty() || !stepper.pairs() || greatest < slender * least)
    return;
  const double across = least / fem::mean_diameter(stepper.space());
  if (across < enough)
    warnings.push_back(fmt::format("the slender clamped body has {:.2g} elements of degree 1 across its "
                                   "thickness, which make it about {:.2g} % too stiff in bending; set "
                                   "mesh.degree = 2",
                                   across, percent_at_four * 16 / (across * across)));
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
  warn_of_normals(stepper, figures.warnings);
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
