// SPDX-License-Identifier: GPL-3.0-or-later
// Friction of contact pairs: tangents, coefficients, and the ways of the obstacles along their surfaces.
#include "base/error.h"
#include "base/text.h"
#include "contact/pairs.h"
#include "contact/pressure.h"
#include "contact/row_basis.h"
#include "contact/tangents.h"
#include "linalg/dense.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

namespace signorini::contact {

void ContactPairs::add_tangents(const BoundaryNode& node, ConstraintRows::Group& group) const {
  const auto dim = static_cast<std::size_t>(dim_);
  std::array<double, 3> nu{};
  for (std::size_t c = 0; c < dim; ++c)
    nu[c] = group.entries[c].coefficient;
  const auto add = [&](const std::array<double, 3>& tangent) {
    std::vector<ConstraintRows::Entry> row = group.entries;
    double held = 0, whole = 0;
    for (std::size_t c = 0; c < dim; ++c) {
      row[c].coefficient = tangent[c];
      whole = std::hypot(whole, tangent[c]);
      held = std::hypot(held, row[c].clamped ? tangent[c] : 0);
    }
    if (held >= (1 - RowBasis::dependence_limit) * whole)
      return; // the node cannot slip along it
    if (held > RowBasis::dependence_limit * whole)
      throw UserError(fmt::format(
          "{}.friction: a clamp holds the node at {} along a part of the obstacle's tangent; clamp the whole "
          "node, or end the group before it",
          keys_[static_cast<std::size_t>(node.obstacle)], point_text(node.x.data())));
    group.others.push_back(std::move(row));
  };
  const std::array<std::array<double, 3>, 2> along = tangents(nu, dim_);
  for (std::size_t direction = 0; direction + 1 < dim; ++direction)
    add(along[direction]);
}

void ContactPairs::add_surface_ways(int obstacle, const scene::Field& velocity, double t0, double t1,
                                    std::span<double> way) const {
  const auto dim = static_cast<std::size_t>(dim_);
  std::array<double, 3> v{};
  for (int i = 0; i < count(); ++i) {
    if (obstacles_[i] != obstacle)
      continue;
    velocity.evaluate(&points_[3 * static_cast<std::size_t>(i)], (t0 + t1) / 2, v.data());
    for (std::size_t c = 1; c < rows_->size(i); ++c)
      way[rows_->row(i, c)] +=
          (t1 - t0) * dot(rows_->motion(static_cast<int>(rows_->row(i, c))), std::span(v).first(dim));
  }
}

void ContactPairs::obstacle_ways(double t0, double t1, std::span<double> way) const {
  std::ranges::fill(way, 0);
  const auto dim = static_cast<std::size_t>(dim_);
  for (const std::size_t obstacle : moving_) {
    const Obstacle::Place from = shapes_[obstacle]->place(t0), to = shapes_[obstacle]->place(t1);
    std::array<double, 3> motion{};
    for (std::size_t c = 0; c < dim; ++c)
      motion[c] = to.point[c] - from.point[c];
    for (int i = 0; i < count(); ++i)
      for (std::size_t c = 1; c < rows_->size(i) && obstacles_[i] == static_cast<int>(obstacle); ++c)
        way[rows_->row(i, c)] =
            dot(rows_->motion(static_cast<int>(rows_->row(i, c))), std::span(motion).first(dim));
  }
  for (std::size_t obstacle = 0; obstacle < surface_velocity_.size(); ++obstacle)
    if (surface_velocity_[obstacle])
      add_surface_ways(static_cast<int>(obstacle), *surface_velocity_[obstacle], t0, t1, way);
}

void ContactPairs::set_tresca_areas(const fem::Space& space, const std::vector<scene::Contact>& contacts) {
  tresca_areas_ = nodal_areas(space, *this, contacts);
  const double largest = tresca_areas_.empty() ? 0 : *std::ranges::max_element(tresca_areas_);
  constexpr double rounding = 1e-12; // of integrals that vanish, as those of vertices in degree 2 in space
  for (int i = 0; i < count(); ++i)
    if (!contacts[static_cast<std::size_t>(obstacles_[i])].bound || tresca_areas_[i] <= rounding * largest)
      tresca_areas_[i] = 0;
}

void ContactPairs::friction(double t, double impulse, std::vector<double>& friction) const {
  friction.assign(friction_at_start_.begin(), friction_at_start_.end());
  if (friction_varies_)
    evaluate_friction(t, friction);
  for (std::size_t i = 0; i < tresca_areas_.size(); ++i)
    if (rows_->law(static_cast<int>(i)).acts_open())
      friction[i] *= impulse * tresca_areas_[i];
}

void ContactPairs::evaluate_friction(double t, std::span<double> values) const {
  for (int i = 0; i < count(); ++i)
    if (const auto& friction = friction_[obstacles_[i]]) {
      const double* x = &points_[3 * static_cast<std::size_t>(i)];
      values[i] = friction->value(0, x, t);
      if (values[i] < 0)
        throw UserError(
            fmt::format("{}: found {:.6g} at the node at {} and t = {:.6g} s; a {} must be at least 0",
                        friction->key(), values[i], point_text(x), t,
                        rows_->law(i).acts_open() ? "bound of friction" : "coefficient of friction"));
    }
}

std::vector<scene::Contact> without_friction(std::vector<scene::Contact> contacts) {
  for (scene::Contact& contact : contacts) {
    contact.friction = 0;
    contact.bound.reset();
  }
  return contacts;
}

} // namespace signorini::contact
