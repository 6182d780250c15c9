// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/point_force.h"
#include "base/collective.h"
#include "base/text.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::step {

namespace {

/// Nodes near a point, on all ranks.
struct Found {
  int count = 0;                    ///< number of nodes at the point
  std::array<double, 4> nearest{};  ///< distance of the nearest node, m, and its coordinates
  std::optional<std::size_t> own{}; ///< number of the node at the point, on its rank
};

Found nodes_at(const fem::Space& space, const std::vector<double>& at) {
  constexpr double digits = 1e-6; // of the body's diameter, as coordinates are written
  const double tolerance = digits * space.mesh().diameter();
  Found found{.nearest = {std::numeric_limits<double>::infinity()}};
  for (std::size_t node = 0; node < space.points().size() / 3; ++node) {
    const double* x = &space.points()[3 * node];
    double square = 0;
    for (std::size_t c = 0; c < at.size(); ++c)
      square += (x[c] - at[c]) * (x[c] - at[c]);
    const double distance = std::sqrt(square);
    if (distance < found.nearest[0])
      found.nearest = {distance, x[0], x[1], x[2]};
    if (distance <= tolerance) {
      ++found.count;
      found.own = node;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &found.count, 1, MPI_INT, MPI_SUM, space.comm());
  const std::vector<std::array<double, 4>> nearest = gather(space.comm(), std::vector{found.nearest});
  found.nearest = *std::ranges::min_element(nearest);
  return found;
}

} // namespace

std::optional<std::size_t> node_at(const fem::Space& space, const std::vector<double>& at,
                                   const std::string& key) {
  const Found found = nodes_at(space, at);
  const auto text = [&](const double* x) { return point_text(x, space.dim()); };
  if (found.count == 0)
    throw UserError(fmt::format("{}.at: found {} m, where the mesh has no node; the nearest node is at {} m. "
                                "Put a point of the .geo there",
                                key, text(at.data()), text(&found.nearest[1])));
  if (found.count > 1)
    throw UserError(fmt::format("{}.at: found {} m, where the mesh has {} nodes that are not connected; "
                                "choose a point with one node",
                                key, text(at.data()), found.count));
  return found.own;
}

namespace {

/// Throws UserError, on every rank, if a force at a node on the axis of a body of revolution has a radial
/// part.
void require_along_axis(const fem::Space& space, std::optional<std::size_t> node,
                        const scene::PointForce& force, const std::string& key) {
  on_all_ranks(space.comm(), [&] {
    if (node && space.on_axis(static_cast<int>(*node)) && !scene::vanishes({force.value.front()}))
      throw UserError(
          fmt::format("{}.value: found \"{}\" for x, the radius, at a node on the axis; expected 0, "
                      "since forces there act along the axis y",
                      key, force.value.front().text));
  });
}

std::vector<double> coordinates(const fem::Space& space, std::size_t node) {
  const double* const x = &space.points()[3 * node];
  return {x, x + 3};
}

} // namespace

PointForce::PointForce(const fem::Space& space, const scene::PointForce& force, const std::string& key,
                       double end)
    : dim_(static_cast<std::size_t>(space.dim())), node_(node_at(space, force.at, key)),
      point_(node_ ? coordinates(space, *node_) : std::vector<double>()),
      profile_(space.comm(), scene::Field(force.value, key + ".value", true), point_, end),
      value_(dim_ * (point_.size() / 3)) {
  require_along_axis(space, node_, force, key);
}

PointForce::PointForce(const fem::Space& space, std::size_t virtual_node, const scene::Components& value,
                       double factor, const std::string& key, double end)
    : dim_(static_cast<std::size_t>(space.dim())), factor_(factor),
      point_(space.layout().owns_virtual_nodes() ? 3 : 0),
      profile_(space.comm(), scene::Field(value, key, true), point_, end),
      value_(dim_ * (point_.size() / 3)) {
  if (space.layout().owns_virtual_nodes())
    node_ = static_cast<std::size_t>(space.layout().mesh_nodes()) + virtual_node;
}

void PointForce::add(const TimeStep& step, Vec sum) const {
  profile_.mean(step.begin, step.end, value_);
  const petsc::WriteArray entries(sum);
  for (std::size_t c = 0; c < value_.size(); ++c)
    entries[dim_ * *node_ + c] += factor_ * value_[c];
}

} // namespace signorini::step
