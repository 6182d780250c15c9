// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/moving_clamps.h"
#include "base/collective.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <utility>

namespace signorini::step {
using petsc::check;

namespace {

bool moves(const scene::Clamp& clamp) { return clamp.value && !scene::vanishes(*clamp.value); }

/// Weights of the derivative at the end t of the interval from t to t + reach:
///     f'(t) = Σ_j weight_j (f(t + place_j · reach) − f(t)) / reach
/// It is that of the polynomial through the values at Chebyshev points, accurate to rounding for motions that
/// the steps resolve.
struct Slope {
  static constexpr int degree = 6;
  std::array<double, degree + 1> place{}, weight{};
  Slope() {
    for (int j = 1; j <= degree; ++j) {
      const double x = std::cos(std::numbers::pi * j / degree), sign = j % 2 == 0 ? 1 : -1;
      place[j] = (1 - x) / 2;
      weight[j] = -2 * sign * (j == degree ? 0.5 : 2 / (1 - x));
    }
    place[degree] = 1;
  }
};

} // namespace

bool MovingClamps::in(const std::vector<scene::Clamp>& clamps) { return std::ranges::any_of(clamps, moves); }

MovingClamps::MovingClamps(const fem::Space& space, const std::vector<scene::Clamp>& clamps) : space_(space) {
  for (std::size_t i = 0; i < clamps.size(); ++i)
    if (moves(clamps[i])) {
      const std::string key = scene::clamp_key(clamps, i);
      clamps_.push_back({scene::Field(*clamps[i].value, key + ".value", true),
                         space.nodes_on(clamps[i].on, key + ".on"),
                         fem::component_numbers(clamps[i].components, space.dim())});
    }
  at_rest_ = std::ranges::none_of(clamps_, [](const Clamp& clamp) { return clamp.field.depends_on_time(); });
}

template <class Visit>
void MovingClamps::for_each_dof(Visit&& visit) const {
  for (const Clamp& clamp : clamps_)
    for (int node : clamp.nodes)
      for (int c : clamp.components)
        visit(static_cast<std::size_t>(node * space_.dim() + c));
}

MovingClamps::Evaluation MovingClamps::storage() const {
  Evaluation at;
  for (petsc::Vector* x : {&at.position, &at.velocity, &at.force, &at.starting_velocity})
    *x = space_.vector();
  return at;
}

void MovingClamps::evaluate(const TimeStep& step, Evaluation& at) const {
  const double t = step.end, reach = step.k == 0 ? step.tau : -step.tau; // keeps times within the run
  if (at.t >= 0 && (at_rest_ || (at.t == t && at.difference_interval == reach))) {
    at.difference_interval = reach;
    return;
  }
  static const Slope slope;
  const petsc::WriteArray g(at.position), v(at.velocity);
  at.t = -1;
  at.difference_interval = reach;
  at.forced = 0;
  on_all_ranks(space_.comm(), [&] {
    std::array<double, 3> here{}, there{}, rate{};
    for (const Clamp& clamp : clamps_)
      for (int node : clamp.nodes) {
        if (clamp.field.depends_on_place() || node == clamp.nodes.front()) {
          const double* x = &space_.points()[3 * static_cast<std::size_t>(node)];
          clamp.field.evaluate(x, t, here.data());
          rate = {};
          for (std::size_t j = 1; clamp.field.depends_on_time() && j < slope.place.size(); ++j) {
            clamp.field.evaluate(x, t + slope.place[j] * reach, there.data());
            for (std::size_t c = 0; c < clamp.components.size(); ++c)
              rate[c] += slope.weight[j] * (there[c] - here[c]) / reach;
          }
          for (std::size_t c = 0; c < clamp.components.size(); ++c)
            rate[c] = clamp.field.slope(c, t, reach > 0).value_or(rate[c]);
        }
        for (std::size_t c = 0; c < clamp.components.size(); ++c) {
          const auto dof = static_cast<std::size_t>(node * space_.dim() + clamp.components[c]);
          g[dof] = here[c], v[dof] = rate[c];
        }
      }
  });
  at.t = t;
}

Vec MovingClamps::starting_velocity(Evaluation& at, Vec y, Vec v) const {
  check(VecCopy(v, at.starting_velocity));
  const petsc::ReadArray from(y), to(at.position), before(v), after(at.velocity);
  const petsc::WriteArray values(at.starting_velocity);
  for_each_dof([&](std::size_t dof) {
    values[dof] = (before[dof] - after[dof]) / 2 + (to[dof] - from[dof]) / std::abs(at.difference_interval);
  });
  return at.starting_velocity;
}

void MovingClamps::copy(Vec from, Vec to) const {
  const petsc::ReadArray source(from);
  const petsc::WriteArray target(to);
  for_each_dof([&](std::size_t dof) { target[dof] = source[dof]; });
}

void MovingClamps::apply(Evaluation& at, Mat D, const fem::DirichletDofs& clamped, double diagonal,
                         Vec r) const {
  PetscObjectId id = 0;
  check(PetscObjectGetId(PetscObject(D), &id));
  if (std::exchange(at.forced, id) != id)
    check(MatMult(D, at.position, at.force));
  check(VecAXPY(r, -1, at.force));
  clamped.clear(r);
  const petsc::ReadArray position(at.position);
  const petsc::WriteArray values(r);
  for_each_dof([&](std::size_t dof) { values[dof] = diagonal * position[dof]; });
}

} // namespace signorini::step
