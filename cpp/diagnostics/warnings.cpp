// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/warnings.h"
#include "base/collective.h"
#include "base/text.h"
#include "contact/tangents.h"
#include "linalg/dense.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>

namespace signorini::diagnostics {
using petsc::check;

namespace {

constexpr int wanted = 5, few = 2;

using Point = std::array<double, 3>;

/// Neighbouring candidate, in coordinates of the obstacle's tangent plane.
struct Neighbour {
  double distance, xi, eta, rise; ///< m; rise: gap minus the gap at the centre
};

/// Returns the nearest candidates of the same obstacle around candidate `centre`, in ascending distance.
std::vector<Neighbour> neighbours(const contact::ContactPairs& pairs, std::size_t centre) {
  const auto dim = static_cast<std::size_t>(pairs.dim());
  const std::size_t most = dim == 2 ? 4 : 18; // two on either side, two rings of triangles
  const std::vector<double>& x = pairs.points();
  Point nu{};
  std::copy_n(&pairs.normals()[dim * centre], dim, nu.begin());
  const std::array<Point, 2> along = contact::tangents(nu, pairs.dim());
  std::vector<Neighbour> all;
  for (std::size_t i = 0; i < pairs.psi().size(); ++i) {
    if (i == centre || pairs.obstacles()[i] != pairs.obstacles()[centre])
      continue;
    const Point r{x[3 * i] - x[3 * centre], x[3 * i + 1] - x[3 * centre + 1],
                  x[3 * i + 2] - x[3 * centre + 2]};
    const auto component = [&](const Point& e) {
      return std::inner_product(r.begin(), r.end(), e.begin(), 0.0);
    };
    all.push_back({std::hypot(r[0], r[1], r[2]), component(along[0]), component(along[1]),
                   pairs.psi()[i] - pairs.psi()[centre]});
  }
  const std::size_t count = std::min(most, all.size());
  std::ranges::partial_sort(all, all.begin() + static_cast<std::ptrdiff_t>(count), {}, &Neighbour::distance);
  all.resize(count);
  return all;
}

/// Paraboloid of revolution (in the plane a parabola) that fits the gap around a candidate.
struct Paraboloid {
  double bend;  ///< mean curvature, 1/m
  double slope; ///< at the candidate
  /// Distance of the lowest point, whose gap is the least, from the candidate, m.
  [[nodiscard]] double lowest() const { return slope / bend; }
};

/// Fits the gap by least squares. Returns nothing if there are too few candidates. `h`: spacing of the
/// candidates, m.
std::optional<Paraboloid> paraboloid(const std::vector<Neighbour>& around, double h, std::size_t dim) {
  const std::size_t n = dim + 1;
  std::vector<double> normal(n * n), right(n);
  const auto add = [&](double xi, double eta, double rise) {
    const std::array<double, 4> row{1, xi, dim == 2 ? (xi * xi) / 2 : eta, (xi * xi + eta * eta) / 2};
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j)
        normal[n * i + j] += row[i] * row[j];
      right[i] += row[i] * rise;
    }
  };
  add(0, 0, 0);
  for (const Neighbour& one : around)
    add(one.xi / h, one.eta / h, one.rise);
  if (!solve_dense(normal, right))
    return std::nullopt;
  return Paraboloid{right.back() / (h * h),
                    (dim == 2 ? std::abs(right[1]) : std::hypot(right[1], right[2])) / h};
}

/// Whether all neighbours are on one side of the candidate: it is at an end of the contact group.
bool at_an_end(const std::vector<Neighbour>& around) {
  constexpr double side =
      0.95 * std::numbers::pi; // an angle without neighbours; less than straight for rounding
  std::vector<double> angles;
  for (const Neighbour& one : around)
    angles.push_back(std::atan2(one.eta, one.xi));
  std::ranges::sort(angles);
  double widest =
      angles.empty() ? 2 * std::numbers::pi : angles.front() + 2 * std::numbers::pi - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i)
    widest = std::max(widest, angles[i] - angles[i - 1]);
  return widest > side;
}

} // namespace

CandidateSpacing candidate_spacing(const contact::ContactPairs& pairs, int candidate, int most, double force,
                                   double modulus) {
  const std::vector<Neighbour> around = neighbours(pairs, static_cast<std::size_t>(candidate));
  const bool plane = pairs.dim() == 2;
  const double x = pairs.points()[3 * static_cast<std::size_t>(candidate)];
  const bool revolved = pairs.axisymmetric(), on_axis = revolved && x == 0;
  if (revolved && !on_axis) // a ring, whose contact is that of a cylinder as long as its circumference
    force /= 2 * std::numbers::pi * x;
  std::size_t ring = std::min<std::size_t>(plane ? 2 : 4, around.size());
  const bool at_end = plane ? ring < 2 || around[0].xi * around[1].xi > 0 : at_an_end(around);
  if (plane && at_end) // the last node of a line
    ring = std::min<std::size_t>(ring, 1);
  if (ring == 0)
    return {pairs.diameter(), 0};
  CandidateSpacing spacing;
  for (std::size_t i = 0; i < ring; ++i)
    spacing.found += around[i].distance / static_cast<double>(ring);
  // Five nodes should cover the area, in the plane the length, that the nodes in contact cover now: the least
  // refinement of a zone.
  const double share = static_cast<double>(most) / wanted,
               finer = spacing.found * (plane ? share : std::sqrt(share));
  const std::optional<Paraboloid> fit =
      paraboloid(around, spacing.found, static_cast<std::size_t>(pairs.dim()));
  const double bend = fit ? fit->bend : 0;
  if (bend * spacing.found > 1) // the gap opens as fast as the nodes are apart
    return {spacing.found, 0};
  const bool round = bend * spacing.found * spacing.found > pairs.gap_tolerance();
  if (at_end && !(round && fit->lowest() < spacing.found)) // an edge or a corner is pressed on the obstacle
    return {spacing.found, 0};
  spacing.enough = finer;
  if (bend > 0) {
    const double radius = plane && !on_axis
                              ? std::sqrt(4 * force / (std::numbers::pi * modulus * bend)) // Hertz
                              : std::cbrt(3 * force / (4 * modulus * bend));
    // Puts the ring around a node in the middle, in the plane two nodes on either side of it, on the axis
    // four nodes beside it, within the zone; forces on coarse meshes are too large.
    constexpr double part = 0.7;
    spacing.enough = std::min(finer, part * (on_axis ? radius / 4 : plane ? radius / 2 : radius));
  }
  return spacing;
}

ContactResolution::ContactResolution(const step::Stepper& stepper, const scene::Scene& scene)
    : stepper_(stepper), scene_(scene), zones_(scene.contacts.size()) {}

void ContactResolution::observe(const trajectory::Frame& frame, const ObstacleForces& forces) {
  for (std::size_t o = 0; o < zones_.size(); ++o) {
    Zone& zone = zones_[o];
    const ObstacleForce& now = forces.each()[o];
    zone.most = std::max(zone.most, now.active);
    const double mean = (std::exchange(zone.last, now.normal_force) + now.normal_force) / 2;
    if (!(mean > zone.force && now.normal_force > 0))
      continue;
    zone.force = mean;
    zone.time = frame.step.end;
    double largest = 0;
    for (std::size_t i = 0; i < frame.contact.status.size(); ++i)
      if (stepper_.pairs()->obstacles()[i] == static_cast<int>(o) && frame.contact.lambda[i] > largest) {
        largest = frame.contact.lambda[i];
        zone.candidate = static_cast<int>(i);
      }
  }
}

std::vector<Warning> ContactResolution::warnings() const {
  std::vector<Warning> found;
  for (std::size_t o = 0; o < zones_.size(); ++o)
    if (zones_[o].candidate >= 0 && zones_[o].most <= few && !whole_face(static_cast<int>(o), zones_[o]))
      found.push_back(warning(static_cast<int>(o), zones_[o]));
  return found;
}

bool ContactResolution::whole_face(int obstacle, const Zone& zone) const {
  const contact::ContactPairs& pairs = *stepper_.pairs();
  int count = 0;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::size_t i = 0; i < pairs.psi().size(); ++i)
    if (pairs.obstacles()[i] == obstacle) {
      ++count;
      least = std::min(least, pairs.psi()[i]);
      most = std::max(most, pairs.psi()[i]);
    }
  return count > 1 && count == zone.most && most - least <= pairs.gap_tolerance();
}

Warning ContactResolution::warning(int obstacle, const Zone& zone) const {
  double modulus = 0;
  for (const scene::Material& material : scene_.materials) {
    const auto [young, poisson] = material.instantaneous_constants();
    const bool plate = stepper_.space().mesh().model() == scene::PlaneModel::plane_stress;
    modulus = std::max(modulus, plate ? young : young / (1 - poisson * poisson));
  }
  const contact::ContactPairs& pairs = *stepper_.pairs();
  const CandidateSpacing spacing = candidate_spacing(pairs, zone.candidate, zone.most, zone.force, modulus);
  const double* x = &pairs.points()[3 * static_cast<std::size_t>(zone.candidate)];
  std::string message = fmt::format(
      "{} at {} m, t = {:.6g} s. At most {} touch{} \"{}\" at once, so that force and motion depend "
      "on single nodes. Nodes there are {:.3g} m apart",
      spacing.enough > 0 ? "the mesh is too coarse"
                         : "an edge, a corner or an end of the contact group is in contact",
      point_text(x, pairs.dim()), zone.time, zone.most == 1 ? "one node" : "two nodes",
      zone.most == 1 ? "es" : "", scene_.contacts[obstacle].name, spacing.found);
  if (spacing.enough > 0) {
    const double ratio = spacing.enough / spacing.found;
    message +=
        fmt::format(", and five or more would touch if they were about {:.2g} m apart", spacing.enough);
    if (scene_.mesh.size)
      message += fmt::format(" (mesh.size = {:.2g})", *scene_.mesh.size * ratio);
    else if (!scene_.mesh.meshed())
      message += fmt::format(" (mesh.scale = {:.2g})", scene_.mesh.scale * ratio);
  } else {
    message += "; a finer mesh hardly brings more of them into contact";
  }
  return {"few nodes in contact", message, spacing.found, spacing.enough};
}

Alternations alternations(const std::vector<contact::ContactLinearisation>& contact) {
  Alternations found;
  std::vector<contact::ActiveSet> closed;
  for (const contact::ContactLinearisation& step : contact)
    closed.push_back(step.closed_set());
  for (std::size_t k = 1; k < closed.size(); ++k) {
    const auto has = [&](std::size_t step, int i) { return std::ranges::binary_search(closed[step], i); };
    found.closed += static_cast<int>(closed[k].size());
    if (k == 1 || k + 1 == closed.size())
      continue;
    for (int i : closed[k])
      found.alternating += !has(k - 1, i) && !has(k + 1, i);
    for (int i : closed[k - 1])
      found.alternating += !has(k, i) && has(k + 1, i);
  }
  return found;
}

std::string calmer_contact(const step::Stepper& stepper) {
  if (stepper.predictor())
    return "try shorter time steps or more viscosity";
  return scene::has_massless_candidates(stepper.contact_scheme())
             ? "try time.scheme = \"contact-stabilized\" (with contact.mass = \"consistent\")"
             : "try time.scheme = \"contact-stabilized\"";
}

namespace {

/// Largest energy lost in contact without a warning, relative to the largest energy. It is above the loss at
/// the default accuracies, and well below a loss that a restitution shows.
constexpr double small_loss = 0.03;

} // namespace

std::vector<Warning> contact_loss(const step::Stepper& stepper, const scene::Scene& scene,
                                  double contact_work, double largest_energy) {
  const double part = largest_energy > 0 ? -contact_work / largest_energy : 0;
  const auto moves = [](const scene::Contact& one) { return scene::moves(one); };
  if (!(part > small_loss) || std::ranges::any_of(scene.contacts, moves))
    return {};
  const bool viscous = std::ranges::any_of(scene.materials, &scene::Material::viscous);
  const std::string massless =
      scene.rigid() || stepper.predictor() ? "" : "; with contact.mass = \"massless\" shorter steps do too";
  const bool short_already = !scene.time.automatic() && scene.time.step <= stepper.wave_time();
  const std::string remedy =
      viscous ? "Shorter steps and smaller elements reduce this error; study --quantity energy_loss shows "
                "which helps more"
      : short_already
          ? "Steps are shorter than the time in which a wave crosses an element in contact: smaller elements "
            "reduce this error most" +
                massless
          : fmt::format(
                "Shorter steps ({}) reduce this error until a step takes {:.1e} s, the time in which a "
                "wave crosses an element in contact. Below that length smaller elements reduce "
                "the error more{}",
                scene.time.automatic() ? "time.tolerance" : "time.step", stepper.wave_time(), massless);
  return {{"energy lost in contact",
           fmt::format("contact removed {:.2g} of the largest energy of the motion, {:.3g} J{}, though the "
                       "obstacles {}. {}",
                       part, largest_energy, stepper.space().mesh().per_depth(),
                       scene.rigid() ? "do no work of their own" : "are at rest", remedy),
           part, small_loss}};
}

namespace {

constexpr double most = 0.5; ///< largest approach in a step without a warning, relative to a depth

/// Returns the extent of the body along a normal, m.
double depth_along(const double* nu, const std::array<double, 3>& extent, std::size_t dim) {
  double sum = 0;
  for (std::size_t c = 0; c < dim; ++c)
    sum += std::abs(nu[c]) * extent[c];
  return sum;
}

} // namespace

Passage::Passage(const step::Stepper& stepper) : stepper_(stepper) {
  if (const contact::ContactPairs* pairs = stepper.pairs()) {
    now_ = pairs->gaps(), before_ = pairs->gaps();
    gaps_.resize(static_cast<std::size_t>(pairs->count()));
    moved_.resize(gaps_.size());
    worst_.resize(static_cast<std::size_t>(pairs->obstacle_count()));
  }
}

void Passage::observe(const trajectory::Frame& frame) {
  const contact::ContactPairs* pairs = stepper_.pairs();
  if (!pairs)
    return;
  std::swap(now_, before_);
  const std::span<const double> psi = pairs->psi(frame.step.end, *now_);
  const auto dim = static_cast<std::size_t>(pairs->dim());
  struct Closing {
    double body = 0, gap = std::numeric_limits<double>::infinity(), depth = 0; ///< m
    double level = 0; ///< distance by which a level set comes closer, m
    const contact::Obstacle* shape = nullptr;
  };
  std::vector<Closing> all(worst_.size());
  for (std::size_t i = 0; i < gaps_.size(); ++i) {
    const double moved = psi[i] - frame.contact.gap[i], before = std::exchange(moved_[i], moved),
                 gap = std::exchange(gaps_[i], frame.contact.gap[i]);
    Closing& one = all[pairs->obstacles()[i]];
    one.shape = pairs->obstacle(static_cast<int>(i));
    one.body = std::max(one.body, std::abs(moved - before));
    one.level = std::max(one.level, std::abs(frame.contact.gap[i] - gap + moved - before));
    if (gap < one.gap) {
      one.gap = gap;
      one.depth = depth_along(&pairs->normals()[dim * i], stepper_.space().mesh().extent(), dim);
    }
  }
  for (std::size_t o = 0; frame.step.k > 0 && o < all.size(); ++o) {
    const Closing& one = all[o];
    const contact::Obstacle::Place &from = before_->place[o], &to = now_->place[o];
    const double way = std::hypot(to.point[0] - from.point[0], to.point[1] - from.point[1],
                                  to.point[2] - from.point[2]),
                 path = one.body + std::max(way, one.level),
                 depth = one.shape && one.shape->surrounds() ? one.depth : std::min(one.depth, 2 * to.radius);
    if (path > most * depth && one.gap < path && path / depth > worst_[o].share)
      worst_[o] = {path / depth, path, depth, frame.step};
  }
}

std::vector<Warning> Passage::warnings() const {
  std::vector<Warning> found;
  for (std::size_t o = 0; o < worst_.size(); ++o)
    if (const Worst& worst = worst_[o]; worst.share > most)
      found.push_back({"passage within a step",
                       fmt::format("{}: in the step to t = {:.6g} s, obstacle and body approach by {:.3g} m. "
                                   "This is {:.3g} times the depth of the thinner one ({:.3g} m). One may "
                                   "pass through the other within the step; set time.step below {:.2g} s",
                                   stepper_.pairs()->key(static_cast<int>(o)), worst.step.end, worst.path,
                                   worst.share, worst.depth, worst.step.tau * most / worst.share),
                       worst.share, most});
  return found;
}

StepWarnings::StepWarnings(const step::Stepper& stepper, const scene::Scene& scene,
                           const step::SceneLoad* load, const trajectory::StepErrors* errors)
    : load_(load), comm_(stepper.space().comm()), passage_(stepper), errors_(errors) {
  if (!errors && stepper.step_lengths())
    errors_ = &own_.emplace(stepper, scene);
}

void StepWarnings::observe(const trajectory::Frame& frame) {
  if (frame.contact.several && several_++ == 0)
    first_several_ = frame.step.end;
  passage_.observe(frame);
  if (own_)
    own_->observe(frame);
}

std::vector<Warning> StepWarnings::warnings() const {
  std::vector<Warning> found = passage_.warnings();
  const auto add = [&](std::vector<Warning> more) { std::ranges::move(more, std::back_inserter(found)); };
  if (load_)
    add(load_->warnings());
  if (errors_)
    add(errors_->warnings());
  const std::vector<double> several =
      broadcast(comm_, std::vector<double>{static_cast<double>(several_), first_several_});
  if (several[0] > 0)
    found.push_back(
        {"several solutions",
         fmt::format("in {:.0f} steps, first at t = {:.4g} s, contact has other solutions too, since "
                     "contact.friction is large. Forces and derivatives there are one choice of several. "
                     "Shorten the steps or lower contact.friction",
                     several[0], several[1]),
         several[0], 0});
  return found;
}

} // namespace signorini::diagnostics
