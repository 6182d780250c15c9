// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/plausibility.h"
#include "base/collective.h"
#include "base/error.h"
#include "diagnostics/largest_stress.h"
#include "fem/coherence.h"
#include "fem/deformation.h"
#include "fem/surface.h"
#include "linalg/dense.h"
#include "step/point_force.h"
#include <algorithm>
#include <cmath>
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

Plausibility::Plausibility(const step::Stepper& stepper, const scene::Scene& scene, int parts)
    : stepper_(stepper), scene_(scene), parts_(parts), largest_energy_state_(stepper.space().vector()),
      gaps_(stepper.rows()) {
  if (stepper.pairs()) {
    psi_ = stepper.pairs()->gaps();
    jumps_ = stepper.pairs()->jumps(stepper.space());
  }
}

void Plausibility::observe(const trajectory::Frame& frame, const StepBalance* balance) {
  if (balance && balance->elastic_energy > energy_) {
    energy_ = balance->elastic_energy;
    check(VecCopy(frame.after.y(), largest_energy_state_));
    largest_energy_time_ = frame.step.end;
  }
  constexpr double rounding = 1e-9;
  const int part = static_cast<int>(parts_ * frame.step.end / stepper_.end() + rounding) + 1;
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
  if (strain_.value > small_strain && strain_.time == t)
    strain_around_ = fem::strain_around(stepper_.space(), y, strain_.at);
  take(rotation_, now.rotation.value, now.rotation.at, small_rotation);
  take(inverted_, static_cast<double>(now.inverted), {}, 0);
  if (stepper_.pairs())
    check_contact(y, t);
  if (jumps_)
    check_slide(y, t);
}

void Plausibility::check_slide(Vec y, double t) {
  const contact::ContactPairs& pairs = *stepper_.pairs();
  const auto dim = static_cast<std::size_t>(pairs.dim());
  std::vector<double> jumps(static_cast<std::size_t>(jumps_->count()));
  jumps_->apply_transpose(y, jumps);
  std::size_t next = 0;
  for (int i = 0; i < pairs.count(); ++i) {
    if (!pairs.mortar_row(i))
      continue;
    const std::span<const double> jump = std::span(jumps).subspan(dim * next++, dim),
                                  nu = std::span(pairs.normals())
                                           .subspan(dim * static_cast<std::size_t>(i), dim);
    if (gaps_[static_cast<std::size_t>(i)] > pairs.gap_tolerance())
      continue;
    const double normal = signorini::dot(jump, nu),
                 along = std::sqrt(std::max(0.0, signorini::dot(jump, jump) - normal * normal)),
                 facets = along / pairs.surfaces(pairs.obstacles()[i])->facet_size();
    const double* x = &pairs.points()[3 * static_cast<std::size_t>(i)];
    if (facets > 1)
      slide_.passed = std::min(slide_.passed, t);
    if (facets > (1 + fem::tie) * slide_.value)
      slide_ = {facets, t, {x[0], x[1], x[2]}, slide_.passed};
  }
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
  const auto add = [&](const char* name, const std::string& key, const std::string& group,
                       std::int64_t facets, const char* what) {
    if (facets > 0)
      warnings.push_back({name,
                          fmt::format("{}: the group \"{}\" has {} facet{} {}", key, group, facets,
                                      facets == 1 ? "" : "s", what),
                          static_cast<double>(facets), 0});
  };
  for (std::size_t i = 0; i < scene_.contacts.size(); ++i) {
    const std::string key = scene::contact_key(scene_.contacts, i) + ".on", &group = scene_.contacts[i].on;
    add("contact inside the body", key, group, fem::inner_facets(space.mesh(), group, key),
        "inside the body, out of reach of any obstacle");
    add("contact on a clamp", key, group,
        fem::facets_among(space, group, key, stepper_.pairs()->clamped_dofs(static_cast<int>(i))),
        "that cannot come into contact, since all nodes there are clamped");
  }
  for (std::size_t i = 0; scene_.load && i < scene_.load->tractions.size(); ++i) {
    const std::string key = fmt::format("load.traction[{}].on", i), &group = scene_.load->tractions[i].on;
    add("traction inside the body", key, group, fem::inner_facets(space.mesh(), group, key),
        "inside the body, where the traction acts too");
  }
}

std::vector<Warning> Plausibility::warnings() {
  if (largest_energy_time_ >= 0)
    check_displacement(largest_energy_state_, std::exchange(largest_energy_time_, -1));
  std::vector<Warning> found;
  add_of_mesh(found);
  if (strain_.value > small_strain) {
    std::string text =
        fmt::format("a principal strain is {} {}; the small-strain model is meant for strains below {} {}",
                    above(strain_.value, small_strain), where(strain_), small_strain, since(strain_));
    if (strain_.value > resolved * strain_around_)
      text += fmt::format(". The mean over the cells around is {:.2g}. Single cells have large strains at "
                          "facets of a coarse mesh, corners and point loads; try smaller elements there",
                          strain_around_);
    found.push_back({"large strain", text, strain_.value, small_strain});
  }
  if (rotation_.value > small_rotation)
    found.push_back(
        {"large rotation",
         fmt::format(
             "the material turns by {} degrees {}; the small-strain model is meant for rotations below "
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
  if (slide_.value > 1)
    found.push_back({"motion beyond a facet",
                     fmt::format("the node {} slid {} facets along the other part; its contact is still with "
                                 "the facets that were opposite in the undeformed parts {}",
                                 where(slide_), above(slide_.value, 1), since(slide_)),
                     slide_.value, 1});
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

} // namespace signorini::diagnostics
