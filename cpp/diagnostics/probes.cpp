// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/probes.h"
#include "base/error.h"
#include "linalg/dense.h"
#include "scene/targets.h"
#include "step/functionals.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::diagnostics {
using petsc::check;

namespace {

constexpr const char* axes[] = {"x", "y", "z"};

std::string key_of(std::size_t probe) { return fmt::format("output.probe[{}]", probe); }

/// Returns a field of V from its values at nodes. `at(x, value)` sets the value (dim entries) at the point x
/// (3 coordinates).
template <class At>
petsc::Vector field(const fem::Space& space, At&& at) {
  petsc::Vector result = space.vector();
  const petsc::WriteArray values(result);
  const auto dim = static_cast<std::size_t>(space.dim());
  for (std::size_t node = 0; node < static_cast<std::size_t>(space.owned_nodes()); ++node)
    at(&space.points()[3 * node], &values[dim * node]);
  return result;
}

/// Returns the unit infinitesimal rotation about an axis (0 to 2; in the plane 2) through `centre`, as a
/// field of V.
petsc::Vector rotation(const fem::Space& space, std::size_t axis, const std::vector<double>& centre) {
  const std::size_t first = (axis + 1) % 3, second = (axis + 2) % 3;
  return field(space, [&](const double* x, double* value) { // e × (x − centre)
    const auto arm = [&](std::size_t c) { return x[c] - centre[c]; };
    if (second < static_cast<std::size_t>(space.dim()))
      value[second] = arm(first);
    if (first < static_cast<std::size_t>(space.dim()))
      value[first] = -arm(second);
  });
}

petsc::Vector product(Mat matrix, Vec x) {
  petsc::Vector result = petsc::zero_like(x);
  check(MatMult(matrix, x, result));
  return result;
}

} // namespace

Probes::Probes(const step::Stepper& stepper, const scene::Scene& scene)
    : stepper_(stepper), dim_(static_cast<std::size_t>(stepper.space().dim())) {
  const std::vector<scene::Probe>& probes = scene.output.probes;
  find_points(probes);
  for (std::size_t i = 0, points = 0; i < probes.size(); ++i) {
    const scene::Probe& probe = probes[i];
    if (probe.point)
      add_point(probe, points++);
    if (probe.on)
      add_group(probe, key_of(i) + ".on");
    if (probe.body)
      add_body(probe);
    if (probe.obstacle)
      add_obstacle(probe, static_cast<std::size_t>(scene::obstacle_number(scene.contacts, *probe.obstacle)));
  }
}

void Probes::add_column(const std::string& probe, const std::string& quantity, const ProbeFunction& value) {
  names_.push_back(probe + "." + quantity);
  values_.push_back(value);
}

template <class Make>
void Probes::add_vector(const std::string& probe, const std::string& quantity, Make&& make) {
  for (std::size_t c = 0; c < dim_; ++c)
    add_column(probe, fmt::format("{}_{}", quantity, axes[c]), make(c));
}

void Probes::find_points(const std::vector<scene::Probe>& probes) {
  std::vector<double> points;
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < probes.size(); ++i)
    if (probes[i].point) {
      points.insert(points.end(), probes[i].point->begin(), probes[i].point->end());
      which.push_back(i);
      points.resize(3 * which.size());
    }
  if (which.empty())
    return;
  sampler_.emplace(stepper_.space(), points);
  for (std::size_t j = 0; j < which.size(); ++j)
    step::require_inside(stepper_.space(), *sampler_, j, *probes[which[j]].point, key_of(which[j]));
}

Probes::ProbeFunction Probes::linear(std::size_t weights, Vec Sample::* field, double factor, double offset) {
  return [=](const Sample& now) { return factor * petsc::dot(now.weights[weights], now.*field) + offset; };
}

Probes::ProbeFunction Probes::acceleration(std::size_t weights) {
  return [=](const Sample& now) {
    const Vec w = now.weights[weights];
    return now.v_before ? (petsc::dot(w, now.v) - petsc::dot(w, now.v_before)) / now.tau : 0;
  };
}

void Probes::add_point(const scene::Probe& probe, std::size_t number) {
  const std::size_t first = dim_ * number;
  add_vector(probe.name, "displacement",
             [=](std::size_t c) { return [=](const Sample& now) { return now.y_at[first + c]; }; });
  add_vector(probe.name, "velocity",
             [=](std::size_t c) { return [=](const Sample& now) { return now.v_at[first + c]; }; });
  if (!probe.acceleration)
    return;
  points_accelerate_ = true;
  add_vector(probe.name, "acceleration", [=](std::size_t c) {
    return [=](const Sample& now) {
      return now.v_before ? (now.v_at[first + c] - now.v_at_before[first + c]) / now.tau : 0;
    };
  });
}

void Probes::add_obstacle(const scene::Probe& of, std::size_t obstacle) {
  const std::string& probe = of.name;
  add_vector(probe, "force", [=](std::size_t c) {
    return [=](const Sample& now) { return now.obstacles[obstacle].force[c]; };
  });
  add_vector(probe, "impulse", [=](std::size_t c) {
    return [=](const Sample& now) { return now.obstacles[obstacle].impulse[c]; };
  });
  const contact::RigidMotion* motion = stepper_.pairs()->rigid(static_cast<int>(obstacle));
  if (!motion)
    return;
  const std::size_t first = weights_.size();
  for (std::size_t c = 0; c < dim_ + motion->rotations(); ++c)
    weights_.push_back(motion->weights(c));
  add_vector(probe, "displacement", [&](std::size_t c) { return linear(first + c, &Sample::y); });
  add_vector(probe, "velocity", [&](std::size_t c) { return linear(first + c, &Sample::v); });
  if (of.acceleration)
    add_vector(probe, "acceleration", [&](std::size_t c) { return acceleration(first + c); });
  for (const auto& [quantity, field] : {std::pair("rotation", &Sample::y), std::pair("rate", &Sample::v)})
    for (std::size_t c = 0; c < motion->rotations(); ++c)
      add_column(probe,
                 motion->rotations() == 1 ? std::string(quantity) : fmt::format("{}_{}", quantity, axes[c]),
                 linear(first + dim_ + c, field));
}

void Probes::add_group(const scene::Probe& of, const std::string& key) {
  const std::string &probe = of.name, &group = *of.on;
  const fem::Space& space = stepper_.space();
  const petsc::Matrix L2 = fem::assemble_L2(space, group, key);
  const std::size_t first = weights_.size();
  for (std::size_t c = 0; c < dim_; ++c)
    weights_.push_back(step::mean(space, L2, c).weights);
  add_vector(probe, "displacement", [&](std::size_t c) { return linear(first + c, &Sample::y); });
  add_vector(probe, "velocity", [&](std::size_t c) { return linear(first + c, &Sample::v); });
  if (of.acceleration)
    add_vector(probe, "acceleration", [&](std::size_t c) { return acceleration(first + c); });
  if (space.mesh().group_dimension(group, key) < space.dim())
    add_reaction(probe, group, key);
}

void Probes::add_reaction(const std::string& probe, const std::string& group, const std::string& key) {
  const fem::Space& space = stepper_.space();
  const std::size_t first = weights_.size();
  const std::vector<int> nodes = space.nodes_on(group, key);
  long held = 0;
  for (std::size_t c = 0; c < dim_; ++c) {
    weights_.push_back(space.vector());
    const petsc::WriteArray values(weights_.back());
    for (const int node : nodes)
      if (stepper_.clamped().contains(node, static_cast<int>(c)) && !(c == 0 && space.on_axis(node))) {
        values[dim_ * static_cast<std::size_t>(node) + c] = 1;
        ++held;
      }
  }
  MPI_Allreduce(MPI_IN_PLACE, &held, 1, MPI_LONG, MPI_SUM, space.comm());
  if (held == 0) {
    weights_.resize(first);
    return;
  }
  reactions_ = true;
  add_vector(probe, "reaction", [&](std::size_t c) { return linear(first + c, &Sample::reactions); });
}

void Probes::add_body(const scene::Probe& of) {
  const std::string& probe = of.name;
  const fem::Space& space = stepper_.space();
  const petsc::Vector places =
      field(space, [&](const double* x, double* value) { std::copy_n(x, dim_, value); });
  const std::size_t first = weights_.size();
  std::vector<double> centre(3);
  double mass = 0;
  for (std::size_t c = 0; c < dim_; ++c) {
    step::Mean mean = step::mean(space, stepper_.M(), c);
    mass = mean.measure;
    centre[c] = petsc::dot(mean.weights, places);
    weights_.push_back(std::move(mean.weights));
  }
  if (space.mesh().axisymmetric()) { // the centre stays on the axis, and the body does not turn
    constexpr std::size_t along = 1;
    add_column(probe, "center_y", linear(first + along, &Sample::y, 1, centre[along]));
    add_column(probe, "momentum_y", linear(first + along, &Sample::v, mass));
    if (of.acceleration)
      add_column(probe, "acceleration_y", acceleration(first + along));
    return;
  }
  add_vector(probe, "center", [&](std::size_t c) { return linear(first + c, &Sample::y, 1, centre[c]); });
  add_vector(probe, "momentum", [&](std::size_t c) { return linear(first + c, &Sample::v, mass); });
  if (of.acceleration)
    add_vector(probe, "acceleration", [&](std::size_t c) { return acceleration(first + c); });
  add_rotation(probe, centre);
}

void Probes::add_rotation(const std::string& probe, const std::vector<double>& centre) {
  const std::size_t first = weights_.size(), count = dim_ == 2 ? 1 : 3;
  std::vector<petsc::Vector> moments; // M r for the unit rotations r
  std::vector<double> inertia(count * count);
  for (std::size_t a = 0; a < count; ++a) {
    const petsc::Vector r = rotation(stepper_.space(), dim_ == 2 ? 2 : a, centre);
    moments.push_back(product(stepper_.M(), r));
    for (std::size_t b = 0; b <= a; ++b)
      inertia[a * count + b] = inertia[b * count + a] = petsc::dot(r, moments[b]);
  }
  if (factorise_dense(inertia, count) != 0 || invert_factorised(inertia, count) != 0)
    throw SolverFailure("the moments of inertia of the body are not positive");
  for (std::size_t a = 0; a < count; ++a) {
    weights_.push_back(stepper_.space().vector());
    for (std::size_t b = 0; b < count; ++b)
      check(VecAXPY(weights_.back(), inertia[a * count + b], moments[b]));
    add_column(probe, count == 1 ? "rotation" : fmt::format("rotation_{}", axes[a]),
               linear(first + a, &Sample::y));
  }
}

void Probes::add_values(const trajectory::Frame& frame, const ObstacleForces& forces, Vec reactions,
                        std::vector<double>& values) const {
  Sample now{.y = frame.after.y(),
             .v = frame.after.v(),
             .reactions = reactions,
             .v_before = frame.before ? Vec(frame.before->v()) : nullptr,
             .tau = frame.step.tau,
             .y_at = {},
             .v_at = {},
             .v_at_before = {},
             .obstacles = forces.each(),
             .weights = weights_};
  if (sampler_) {
    now.y_at = (*sampler_)(now.y);
    now.v_at = (*sampler_)(now.v);
    if (points_accelerate_ && now.v_before)
      now.v_at_before = (*sampler_)(now.v_before);
  }
  for (const ProbeFunction& value : values_)
    values.push_back(value(now));
}

} // namespace signorini::diagnostics
