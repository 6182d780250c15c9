// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/plausibility.h"
#include "base/collective.h"
#include "base/error.h"
#include "fem/coherence.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numbers>
#include <numeric>

namespace signorini::diagnostics {
using petsc::check;

namespace {

/// Small strain neglects ε²/2 of a stretch ε: beyond this limit more than a fortieth of it.
constexpr double small_strain = 0.05;
/// In small strain a rotation by θ stretches the body by θ²/2: beyond this limit by 0.4 per cent, as much as
/// a strong load stretches a stiff body.
constexpr double small_rotation = 5 * std::numbers::pi / 180;
/// Error of a linearised gap relative to the node's displacement, with the same limit as strain.
constexpr double small_gap_error = 0.05;

double degrees(double angle) { return angle * 180 / std::numbers::pi; }

/// A value above a limit in four digits, or as many as it takes to show that it is.
std::string above(double value, double limit) {
  int digits = 4;
  std::string text = fmt::format("{:.{}g}", value, digits);
  while (!(std::stod(text) > limit) && digits < std::numeric_limits<double>::max_digits10)
    text = fmt::format("{:.{}g}", value, ++digits);
  return text;
}

/// Value, a second figure and place (3), ordered by the value.
using Row = std::array<double, 5>;
/// The largest of all ranks' rows. Collective.
Row largest(MPI_Comm comm, const Row& mine) {
  const std::vector<Row> all = gather(comm, std::vector<Row>{mine});
  return *std::ranges::max_element(all);
}

} // namespace

Plausibility::Plausibility(const step::Stepper& stepper, const scene::Scene& scene)
    : stepper_(stepper), scene_(scene), strained_(stepper.space().vector()), gaps_(stepper.rows()) {
  if (stepper.pairs())
    psi_ = stepper.pairs()->gaps();
}

void Plausibility::observe(const trajectory::Frame& frame, const StepBalance* balance) {
  if (balance && balance->elastic_energy > energy_) {
    energy_ = balance->elastic_energy;
    check(VecCopy(frame.after.y(), strained_));
    strained_at_ = frame.step.end;
  }
  constexpr double rounding = 1e-9;
  const int part = static_cast<int>(looks * frame.step.end / stepper_.end() + rounding) + 1;
  if (part > looked_ || frame.last) {
    looked_ = part;
    look(frame.after.y(), frame.step.end);
  }
}

void Plausibility::look(Vec y, double t) {
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
    look_at_contact(y, t);
}

void Plausibility::look_at_contact(Vec y, double t) {
  const contact::ContactPairs& pairs = *stepper_.pairs();
  pairs.rows().gap(pairs.psi(t, *psi_), y, gaps_);
  const auto dim = static_cast<std::size_t>(pairs.dim());
  Row slip{}, gap{};
  {
    const petsc::ReadArray values(y);
    const std::span<const double> all = values;
    for (int i = 0; i < pairs.count(); ++i) {
      const double* moved = pairs.displacement(i, all);
      const contact::Obstacle& obstacle = pairs.obstacle(i);
      if (!moved || !obstacle.curved())
        continue;
      const auto candidate = static_cast<std::size_t>(i);
      const double* x = &pairs.points()[3 * candidate];
      const double* nu = &pairs.normals()[dim * candidate];
      std::array<double, 3> place{x[0], x[1], x[2]};
      double square = 0;
      for (std::size_t c = 0; c < dim; ++c) {
        place[c] += moved[c];
        square += moved[c] * moved[c];
      }
      double distance = 0;
      const contact::Obstacle::Place& now =
          psi_->place[static_cast<std::size_t>(pairs.obstacles()[candidate])];
      try {
        distance = obstacle.at(place.data(), now).height;
      } catch (const UserError&) { // no direction leads out of the obstacle: the node is deep inside
        distance = gaps_[candidate] - std::sqrt(square);
      }
      // Where neither distance shows contact, their difference has no effect.
      if (std::min(gaps_[candidate], distance) > pairs.gap_tolerance())
        continue;
      const std::array<double, 3> r = obstacle.from_middle(place.data(), now);
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
  return fmt::format("(first exceeded by t = {:.6g} s)", worst.passed);
}

void Plausibility::add_of_mesh(std::vector<Warning>& warnings) const {
  const fem::Space& space = stepper_.space();
  const int parts = fem::connected_parts(space).count;
  if (parts > 1)
    warnings.push_back(
        {"parts of the mesh",
         fmt::format("the mesh is in {} parts that share no node and move as if the others were not there",
                     parts),
         static_cast<double>(parts), 1});
  for (std::size_t i = 0; i < scene_.contacts.size(); ++i) {
    const std::string key = scene::contact_key(scene_.contacts, i), &group = scene_.contacts[i].on;
    const auto add = [&](const char* name, std::int64_t facets, const char* what) {
      if (facets > 0)
        warnings.push_back({name,
                            fmt::format("{}.on: {} facet{} of the group \"{}\" {}", key, facets,
                                        facets == 1 ? "" : "s", group, what),
                            static_cast<double>(facets), 0});
    };
    add("contact inside the body", fem::inner_facets(space.mesh(), group, key + ".on"),
        "inside the body, where no obstacle can touch it");
    add("contact on a clamp",
        fem::facets_among(space, group, key + ".on", stepper_.pairs()->clamped_dofs(static_cast<int>(i))),
        "held by clamps: they touch nothing, wherever the obstacle is");
  }
}

std::vector<Warning> Plausibility::warnings() {
  if (strained_at_ >= 0)
    look(strained_, std::exchange(strained_at_, -1));
  std::vector<Warning> found;
  add_of_mesh(found);
  if (strain_.value > small_strain)
    found.push_back(
        {"large strain",
         fmt::format("a principal strain is {} {}: small strain is meant for less than {} {}",
                     above(strain_.value, small_strain), where(strain_), small_strain, since(strain_)),
         strain_.value, small_strain});
  if (rotation_.value > small_rotation)
    found.push_back(
        {"large rotation",
         fmt::format("the body turns by {} degrees {}: small strain is meant for less than {:.3g} {}",
                     above(degrees(rotation_.value), degrees(small_rotation)), where(rotation_),
                     degrees(small_rotation), since(rotation_)),
         degrees(rotation_.value), degrees(small_rotation)});
  if (inverted_.value > 0)
    found.push_back(
        {"elements turned inside out",
         fmt::format("{} elements are turned inside out at t = {:.6g} s", inverted_.value, inverted_.time),
         inverted_.value, 0});
  if (slip_.value > 1)
    found.push_back(
        {"motion beyond an obstacle's radius",
         fmt::format(
             "the node {} has come {} radii of the obstacle along it: the obstacle that it sees is the "
             "half-space that was next to it in the undeformed body",
             where(slip_), above(slip_.value, 1)),
         slip_.value, 1});
  if (gap_.value > small_gap_error)
    found.push_back(
        {"linearised gap",
         fmt::format(
             "the gap of the node {} is off by {} of its displacement, since the obstacle is linearised "
             "about the undeformed body: it is meant to be off by less than {}",
             where(gap_), above(gap_.value, small_gap_error), small_gap_error),
         gap_.value, small_gap_error});
  return found;
}

} // namespace signorini::diagnostics
