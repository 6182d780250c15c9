// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/placement.h"
#include "base/collective.h"
#include "base/text.h"
#include "contact/row_basis.h"
#include <algorithm>
#include <fmt/format.h>
#include <functional>

namespace signorini::contact {
namespace {

std::string shown(const ContactPairs& pairs, int i) {
  return point_text(&pairs.points()[3 * static_cast<std::size_t>(i)]);
}

/// Solves 0 ≤ λ ⟂ g + HᵀHλ ≥ 0 at one cluster with the gaps g: −Hλ moves the node to the closest position
/// allowed. λ is in work.lambda. False if there is no such position.
[[nodiscard]] bool place(const ContactPairs& pairs, const ConstraintRows::Cluster& node,
                         std::span<const double> gap, ContactPairs::NodeWork& work) {
  const ConstraintRows& rows = pairs.rows();
  const auto size = static_cast<std::size_t>(node.last - node.first);
  rows.gram(node, work.gram);
  work.lambda.resize(size);
  const auto depends = [&](const ActiveSet& set, int j) {
    RowBasis basis(rows);
    for (int i : set)
      basis.add(node.first + i);
    return !basis.add(node.first + j);
  };
  int steps = 0;
  const auto column = [&](int i) {
    return std::span<const double>(work.gram).subspan(static_cast<std::size_t>(i) * size, size);
  };
  return goldfarb_idnani(column, gap.subspan(static_cast<std::size_t>(node.first), size),
                         pairs.gap_tolerance(), std::cref(depends), work.set, work.lambda, steps,
                         work.solver);
}

} // namespace

void require_room(const ContactPairs& pairs, std::span<const double> psi, double t,
                  ContactPairs::NodeWork& work) {
  if (pairs.rows().clamped() ||
      !pairs.rows().dependent()) // in the first case it depends on the motion of the clamps too
    return;
  on_all_ranks(pairs.comm(), [&] {
    for (const ConstraintRows::Cluster& node : pairs.rows().clusters())
      if (node.dependent && !place(pairs, node, psi, work))
        throw UserError(fmt::format(
            "contact: at t = {:.6g} s the obstacles leave no room for the node at {}, allowed are "
            "obstacles between which every node has a place",
            t, shown(pairs, node.first)));
  });
}

void place_outside(const ContactPairs& pairs, Vec y) {
  const std::vector<int>& obstacles = pairs.obstacles();
  const double allowed = pairs.gap_tolerance();
  ContactPairs::NodeWork work = pairs.node_work();
  std::vector<double> g(pairs.psi().size()), forces(g.size());
  pairs.rows().gap(pairs.psi(), y, g);
  int deepest = -1;
  for (int i = 0; i < pairs.count(); ++i)
    if (g[i] < -allowed && !pairs.projects(obstacles[i]) && (deepest < 0 || g[i] < g[deepest]))
      deepest = i;
  if (deepest >= 0) {
    int all = 0, inside = 0;
    for (int i = 0; i < pairs.count(); ++i)
      if (obstacles[i] == obstacles[deepest]) {
        ++all;
        inside += g[i] < -allowed;
      }
    // A normal that points the wrong way puts bodies deep inside; a face drawn by other digits does not.
    constexpr double shallow = 1e-3; // of the body
    const bool slight = -g[deepest] < shallow * pairs.diameter();
    const char* cure =
        slight ? "move it, or set contact.initial = \"project\", which moves such nodes out"
        : inside == all && all > 1
            ? "move it, or turn the obstacle's normal, which points out of it and may be reversed"
            : "move it, or turn the obstacle's normal, which points out of it, or set "
              "contact.initial = \"project\", which moves such nodes out";
    throw UserError(
        fmt::format("{}: the node at {} starts {:.6g} m inside the obstacle{}; bodies start outside: {}",
                    pairs.key(obstacles[deepest]), shown(pairs, deepest), -g[deepest],
                    inside == all && all > 1 ? fmt::format(", as do all {} candidates", all) : "", cure));
  }
  on_all_ranks(pairs.comm(), [&] {
    for (const ConstraintRows::Cluster& here : pairs.rows().clusters()) {
      if (std::all_of(&g[here.first], &g[here.first] + (here.last - here.first),
                      [&](double depth) { return depth >= -allowed; }))
        continue;
      if (!place(pairs, here, g, work))
        throw UserError(
            fmt::format("contact: the obstacles leave no room for the node at {}, allowed are obstacles "
                        "between which every node has a place",
                        shown(pairs, here.first)));
      std::ranges::copy(work.lambda, &forces[here.first]);
    }
  });
  pairs.rows().apply(-1, forces, y);
}

} // namespace signorini::contact
