// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/approach.h"
#include "base/overloads.h"
#include "fem/rigid_motions.h"
#include "trajectory/time_integrator.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <limits>

namespace signorini::trajectory {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// Returns the time-dependent fields that define an obstacle: its point, radius or distance.
std::vector<scene::Field> fields_of(const scene::Obstacle& obstacle) {
  std::vector<scene::Field> fields;
  const auto add = [&](const scene::Components& components) {
    fields.emplace_back(components, "contact.obstacle", true);
  };
  std::visit(Overloads{[&](const scene::HalfSpace& plane) { add(plane.point); },
                       [&](const scene::Ball& ball) { add(ball.center), add({ball.radius}); },
                       [&](const scene::Cylinder& cylinder) { add(cylinder.point), add({cylinder.radius}); },
                       [&](const scene::SignedDistance& level_set) { add({level_set.distance}); }},
             obstacle);
  std::erase_if(fields, [](const scene::Field& field) { return !field.depends_on_time(); });
  return fields;
}

} // namespace

Approach::Approach(const step::Stepper& stepper, const scene::Scene& scene, const StepErrors& errors)
    : stepper_(stepper), errors_(errors), points_(scene.contacts.size()), obstacles_(scene.contacts.size()),
      clamped_(scene.clamps.size()) {
  const fem::Space& space = stepper.space();
  const double end = stepper.end();
  if (const contact::ContactPairs* pairs = stepper.pairs())
    for (std::size_t i = 0; i < pairs->psi().size(); ++i) {
      std::vector<double>& points = points_[pairs->obstacles()[i]];
      points.insert(points.end(), &pairs->points()[3 * i], &pairs->points()[3 * i] + 3);
      all_candidates_movable_ = all_candidates_movable_ && !immovable(i);
    }
  for (std::size_t o = 0; o < obstacles_.size(); ++o)
    if (const auto& shape = scene.contacts[o].obstacle)
      for (scene::Field& field : fields_of(*shape)) // candidates are on every rank
        obstacles_[o].push_back(
            std::make_unique<fem::TimeProfile>(MPI_COMM_SELF, std::move(field), points_[o], end));
  for (std::size_t c = 0; c < scene.clamps.size(); ++c) {
    if (!scene.clamps[c].value)
      continue;
    const std::string key = scene::clamp_key(scene.clamps, c);
    for (const int node : space.nodes_on(scene.clamps[c].on, key + ".on"))
      clamped_[c].insert(clamped_[c].end(), &space.points()[3 * static_cast<std::size_t>(node)],
                         &space.points()[3 * static_cast<std::size_t>(node)] + 3);
    scene::Field field(*scene.clamps[c].value, key + ".value", true);
    if (field.depends_on_time())
      clamps_.push_back(std::make_unique<fem::TimeProfile>(space.comm(), std::move(field), clamped_[c], end));
  }
}

bool Approach::immovable(std::size_t candidate) const {
  const std::size_t k = errors_.rigid().count();
  const auto first = errors_.rigid_along_normals().begin() + static_cast<std::ptrdiff_t>(candidate * k);
  return std::all_of(first, first + static_cast<std::ptrdiff_t>(k), [](double x) { return x == 0; });
}

Approach::Along Approach::along(std::size_t candidate) const {
  const StepErrors::RigidState& now = errors_.rigid_state();
  const std::size_t k = errors_.rigid().count();
  Along sum;
  for (std::size_t j = 0; j < k; ++j) {
    const double factor = errors_.rigid_along_normals()[candidate * k + j];
    sum.position += factor * now.position[j];
    sum.velocity += factor * now.velocity[j];
    sum.acceleration += factor * now.acceleration[j];
  }
  return sum;
}

double Approach::until_touch(double t) const {
  const contact::ContactPairs* pairs = stepper_.pairs();
  double least = never;
  if (!pairs)
    return least;
  for (std::size_t i = 0; i < pairs->psi().size(); ++i) {
    const auto o = static_cast<std::size_t>(pairs->obstacles()[i]);
    if (!obstacles_[o].empty() || errors_.contact(o) || immovable(i))
      continue;
    const Along body = along(i);
    // The later of two times: the rigid motion comes within reach of the vibration; the gap closes at the
    // rigid velocity plus twice the largest rate of the vibration.
    const double beyond = first_root(pairs->psi()[i] - body.position - errors_.reach(o), -body.velocity,
                                     -body.acceleration),
                 by_gap = first_root(errors_.gaps()[i],
                                     -std::max(body.velocity, 0.0) - 2 * errors_.deformation_rate(o),
                                     -std::max(body.acceleration, 0.0));
    least = std::min(least, std::max(beyond, by_gap));
  }
  for (std::size_t o = 0; o < obstacles_.size(); ++o)
    if (!obstacles_[o].empty() && !errors_.contact(o))
      least = std::min(least, until_moving(o, t));
  return t + least < stepper_.end() ? least : never;
}

double Approach::until_moving(std::size_t obstacle, double t) const {
  const contact::ContactPairs& pairs = *stepper_.pairs();
  std::vector<std::size_t> candidates;
  for (std::size_t i = 0; i < pairs.psi().size(); ++i)
    if (pairs.obstacles()[i] == static_cast<int>(obstacle))
      candidates.push_back(i);
  const contact::Obstacle& shape = *pairs.obstacle(static_cast<int>(candidates.front()));
  const auto within_reach = [&](std::size_t i, const contact::Obstacle::Place& place) {
    const Along body = along(i);
    const double s = place.t - t, moved = body.position + s * body.velocity + s * s / 2 * body.acceleration;
    return shape.at(&pairs.points()[3 * i], place).height - moved <= errors_.reach(obstacle);
  };
  const auto touches = [&](double at) {
    const contact::Obstacle::Place place = shape.place(at);
    return std::ranges::any_of(candidates, [&](std::size_t i) { return within_reach(i, place); });
  };
  // Candidates clamped within reach vibrate there and do not indicate that the obstacle approaches.
  std::erase_if(candidates, [&, place = shape.place(t)](std::size_t i) {
    return immovable(i) && within_reach(i, place);
  });
  if (touches(t))
    return 0;
  // The intervals double, so that near times are sampled densely.
  double from = t;
  for (double length = stepper_.step_lengths()->shortest_step(); from < stepper_.end(); length *= 2) {
    const double to = std::min(from + length, stepper_.end());
    for (const std::unique_ptr<fem::TimeProfile>& profile : obstacles_[obstacle])
      if (std::ranges::any_of(profile->times(from, to), touches))
        return from - t;
    if (touches(to))
      return from - t;
    from = to;
  }
  return never;
}

bool Approach::smooth(double from, double to, double obstacle_tolerance, double clamp_fraction) const {
  for (std::size_t o = 0; o < obstacles_.size(); ++o)
    for (const std::unique_ptr<fem::TimeProfile>& profile : obstacles_[o])
      if (errors_.contact(o) && profile->deviation(from, to) > obstacle_tolerance)
        return false;
  return std::ranges::all_of(clamps_, [&](const std::unique_ptr<fem::TimeProfile>& profile) {
    return profile->deviation(from, to) <= clamp_fraction * profile->range();
  });
}

namespace {

/// Rigid motion of all candidates along their normals ν at one time: displacement (m), velocity (m/s) and
/// acceleration (m/s²).
class RigidFlight {
public:
  RigidFlight(const step::Stepper& stepper, const scene::Scene& scene, int intervals)
      : stepper_(stepper), grid_(stepper.end() / intervals, intervals),
        rigid_(stepper.space(), stepper.clamped(), stepper.M()), rows_(stepper.pairs()->rows()),
        force_(stepper.space().vector()) {
    const auto m = static_cast<std::size_t>(stepper.pairs()->count());
    for (const petsc::Vector& motion : rigid_.basis())
      rows_.apply_transpose(motion, motions_.emplace_back(m));
    const step::State initial = initial_state(stepper, scene);
    rows_.apply_transpose(initial.y(), position_ = std::vector<double>(m));
    velocity_ = along(rigid_.coefficients(initial.v()));
    acceleration_.resize(m);
    const petsc::Vector of_obstacles = stepper.space().vector();
    stepper.pairs()->set_rigid_velocities(of_obstacles);
    of_free_obstacles(of_obstacles, [](double value, double) { return value; });
    add(along_rows(of_obstacles), velocity_);
    if (step::SceneLoad::acts(scene))
      load_.emplace(stepper.space(), stepper.M(), scene, grid_.end());
    if (load_)
      sum_.emplace(stepper.space(), *load_);
  }

  /// Sets the mean acceleration in interval number `interval`, 1 … intervals.
  void accelerate(int interval) {
    if (!load_ || (interval > 1 && !load_->depends_on_time()))
      return;
    assemble(sum_->at(grid_.step(interval)), stepper_.operators(), force_);
    acceleration_ = along(rigid_.products(force_));
    if (stepper_.space().layout().virtual_nodes().empty())
      return;
    of_free_obstacles(force_, [](double force, double mass) { return mass > 0 ? force / mass : 0; });
    add(along_rows(force_), acceleration_);
  }
  void advance(double s) {
    for (std::size_t i = 0; i < position_.size(); ++i) {
      position_[i] += s * velocity_[i] + s * s / 2 * acceleration_[i];
      velocity_[i] += s * acceleration_[i];
    }
  }

  /// Returns whether a rigid motion that the clamps permit moves candidate i along ν.
  [[nodiscard]] bool flies(std::size_t i) const {
    return std::ranges::any_of(motions_, [i](const std::vector<double>& one) { return one[i] != 0; });
  }
  [[nodiscard]] double position(std::size_t i) const { return position_[i]; }
  [[nodiscard]] double velocity(std::size_t i) const { return velocity_[i]; }
  [[nodiscard]] double acceleration(std::size_t i) const { return acceleration_[i]; }

private:
  [[nodiscard]] std::vector<double> along(const std::vector<double>& coefficients) const {
    std::vector<double> sum(position_.size());
    for (std::size_t j = 0; j < motions_.size(); ++j)
      for (std::size_t i = 0; i < sum.size(); ++i)
        sum[i] += coefficients[j] * motions_[j][i];
    return sum;
  }

  /// Sets the entries of x of obstacles with mass to value(entry, mass), without dashpots, and others to
  /// zero: those of the body, and those of obstacles on springs, which are taken to rest.
  template <class Value>
  void of_free_obstacles(Vec x, Value&& value) const {
    const fem::Layout& layout = stepper_.space().layout();
    const petsc::WriteArray values(x);
    const auto dim = static_cast<std::size_t>(layout.dim()), mesh = layout.mesh_dofs();
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i < mesh) {
        values[i] = 0;
        continue;
      }
      const fem::VirtualNode& node = layout.virtual_nodes()[(i - mesh) / dim];
      const std::size_t c = (i - mesh) % dim;
      values[i] = node.stiffness[c] > 0 ? 0 : value(values[i], node.mass[c]);
    }
  }

  /// Returns Hᵀx for the candidates. Collective.
  [[nodiscard]] std::vector<double> along_rows(Vec x) const {
    std::vector<double> sum(position_.size());
    rows_.apply_transpose(x, sum);
    return sum;
  }
  static void add(const std::vector<double>& term, std::vector<double>& sum) {
    std::ranges::transform(term, sum, sum.begin(), std::plus());
  }

  const step::Stepper& stepper_;
  step::TimeGrid grid_; ///< grid of the intervals
  fem::RigidMotions rigid_;
  const contact::ConstraintRows& rows_;
  petsc::Vector force_;
  std::vector<std::vector<double>> motions_;
  std::vector<double> position_, velocity_, acceleration_;
  std::optional<step::SceneLoad> load_;
  std::optional<step::ForceAtStep> sum_;
};

} // namespace

double first_root(double g, double v, double a) {
  if (g <= 0)
    return 0;
  const double square = v * v - 2 * a * g;
  if (square < 0 || (v >= 0 && a >= 0))
    return never;
  return 2 * g / (std::sqrt(square) - v); // the smaller root, without cancellation
}

std::vector<FirstTouch> first_touches(const step::Stepper& stepper, const scene::Scene& scene) {
  const contact::ContactPairs* pairs = stepper.pairs();
  if (!pairs)
    return {};
  constexpr int samples = 256;
  const double h = stepper.end() / samples;
  RigidFlight flight(stepper, scene, samples);
  std::vector<FirstTouch> found(static_cast<std::size_t>(pairs->obstacle_count()));
  contact::ContactPairs::Gaps at = pairs->gaps();
  const auto psi_at = [&](double t) {
    const std::span<const double> psi = pairs->psi(t, at);
    return std::vector<double>(psi.begin(), psi.end());
  };
  std::vector<double> psi = psi_at(0);
  for (int j = 0; j < samples; ++j) {
    flight.accelerate(j + 1);
    const double t = j * h;
    const std::vector<double> next = pairs->moving() ? psi_at(t + h) : psi;
    for (std::size_t i = 0; i < psi.size(); ++i) {
      FirstTouch& one = found[pairs->obstacles()[i]];
      const double gap = psi[i] - flight.position(i), rate = (next[i] - psi[i]) / h - flight.velocity(i),
                   bend = -flight.acceleration(i);
      if (j == 0)
        one.gap = std::min(one.gap, gap);
      one.flies = one.flies || flight.flies(i) || next[i] != psi[i] || pairs->rigid(pairs->obstacles()[i]);
      const double s = first_root(gap - pairs->gap_tolerance(), rate, bend);
      if (s <= h && t + s < one.time) {
        one.time = t + s;
        one.speed = -(rate + bend * s);
      }
      const double lowest = bend > 0 ? std::clamp(-rate / bend, 0.0, h) : rate < 0 ? h : 0;
      if (const double least = gap + lowest * rate + lowest * lowest / 2 * bend; least < one.nearest) {
        one.nearest = least;
        one.nearest_time = t + lowest;
      }
    }
    psi = next;
    flight.advance(h);
  }
  return found;
}

std::vector<std::string> first_touch_lines(const step::Stepper& stepper, const scene::Scene& scene) {
  const std::vector<FirstTouch> all = first_touches(stepper, scene);
  const auto on_springs = [](const scene::Contact& one) {
    return one.rigid && (!one.rigid->stiffness.empty() || !one.rigid->damping.empty());
  };
  std::vector<std::string> absent;
  if (scene.control)
    absent.emplace_back("the control");
  if (stepper.operators().surrounded())
    absent.emplace_back("foundations and mass damping");
  if (std::ranges::any_of(scene.contacts, on_springs))
    absent.emplace_back("the motion of obstacles on springs or dashpots");
  const std::string without = absent.empty() ? "" : fmt::format(", without {}", fmt::join(absent, ", "));
  std::vector<std::string> lines;
  for (std::size_t o = 0; o < all.size(); ++o) {
    const FirstTouch& one = all[o];
    std::string text = fmt::format("first touch of \"{}\": ", scene.contacts[o].name);
    if (!one.flies)
      text += fmt::format("only by deformation, since clamps hold the body; gap {:.4g} m", one.gap);
    else if (one.time == 0)
      text += "at the start";
    else if (one.occurs())
      text += fmt::format("at {:.4g} s with {:.4g} m/s, by the rigid motion from a gap of {:.4g} m{}",
                          one.time, one.speed, one.gap, without);
    else
      text += fmt::format(
          "none before {:.4g} s by the rigid motion{}; gap {:.4g} m at the start, smallest gap {:.4g} m "
          "(at {:.4g} s)",
          stepper.end(), without, one.gap, one.nearest, one.nearest_time);
    lines.push_back(std::move(text));
  }
  return lines;
}

} // namespace signorini::trajectory
