#include "forward/motion.h"
#include "base/collective.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace signorini::forward {
using petsc::check;

namespace {

bool moves(const scene::Clamp& clamp) { return clamp.value && !scene::vanishes(*clamp.value); }

/// The derivative at the end of an interval, of the polynomial through the values at Chebyshev points,
/// accurate to rounding for motions that the steps resolve: f'(t) = Σ_j weight_j (f(t + place_j · reach) −
/// f(t)) / reach, for the interval from t to t + reach.
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

bool PrescribedMotion::in(const std::vector<scene::Clamp>& clamps) {
  return std::ranges::any_of(clamps, moves);
}

PrescribedMotion::PrescribedMotion(const fem::Space& space, const std::vector<scene::Clamp>& clamps, Mat D,
                                   Scheme scheme)
    : space_(space), scheme_(scheme), position_(space.vector()), velocity_(space.vector()),
      force_(space.vector()), driving_(space.vector()) {
  for (std::size_t i = 0; i < clamps.size(); ++i)
    if (moves(clamps[i])) {
      const std::string key = scene::clamp_key(clamps, i);
      clamps_.push_back({scene::Field(*clamps[i].value, key + ".value", true),
                         space.nodes_on(clamps[i].on, key + ".on"),
                         fem::component_numbers(clamps[i].components, space.dim())});
    }
  at_rest_ = std::ranges::none_of(clamps_, [](const Clamp& clamp) { return clamp.field.depends_on_time(); });
  check(MatConvert(D, MATSBAIJ, MAT_INITIAL_MATRIX, D_.put()));
}

template <class Visit>
void PrescribedMotion::for_each_dof(Visit&& visit) const {
  for (const Clamp& clamp : clamps_)
    for (int node : clamp.nodes)
      for (int c : clamp.components)
        visit(static_cast<std::size_t>(node * space_.dim() + c));
}

void PrescribedMotion::go_to(int k) const {
  if (now_ == k || (at_rest_ && now_ >= 0))
    return;
  static const Slope slope;
  const double t = scheme_.time(k), reach = k == 0 ? scheme_.tau : -scheme_.tau; // keeps times within the run
  const petsc::WriteArray g(position_), v(velocity_);
  now_ = -1;
  together(space_.comm(), [&] {
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
        }
        for (std::size_t c = 0; c < clamp.components.size(); ++c) {
          const auto dof = static_cast<std::size_t>(node * space_.dim() + clamp.components[c]);
          g[dof] = here[c], v[dof] = rate[c];
        }
      }
  });
  now_ = k;
}

Vec PrescribedMotion::position(int k) const {
  go_to(k);
  return position_;
}

Vec PrescribedMotion::velocity(int k) const {
  go_to(k);
  return velocity_;
}

Vec PrescribedMotion::driving(int k, Vec y, Vec v) const {
  go_to(k);
  check(VecCopy(v, driving_));
  const petsc::ReadArray from(y), to(position_), before(v), after(velocity_);
  const petsc::WriteArray values(driving_);
  for_each_dof([&](std::size_t dof) {
    values[dof] = (before[dof] - after[dof]) / 2 + (to[dof] - from[dof]) / scheme_.tau;
  });
  return driving_;
}

void PrescribedMotion::copy(Vec from, Vec to) const {
  const petsc::ReadArray source(from);
  const petsc::WriteArray target(to);
  for_each_dof([&](std::size_t dof) { target[dof] = source[dof]; });
}

void PrescribedMotion::apply(int k, const fem::DirichletDofs& clamped, double diagonal, Vec r) const {
  if (!at_rest_ || !forced_) {
    go_to(k);
    check(MatMult(D_, position_, force_));
    forced_ = true;
  }
  check(VecAXPY(r, -1, force_));
  clamped.clear(r);
  const petsc::ReadArray position(position_);
  const petsc::WriteArray values(r);
  for_each_dof([&](std::size_t dof) { values[dof] = diagonal * position[dof]; });
}

} // namespace signorini::forward
