// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/placement.h"
#include "base/collective.h"
#include "base/text.h"
#include "contact/lcp/goldfarb_idnani.h"
#include "contact/row_basis.h"
#include <algorithm>
#include <fmt/format.h>
#include <functional>

namespace signorini::contact {

namespace {

/// Finds the closest position of a node that satisfies the constraints of all its pairs: solves 0 ≤ λ ⟂ g +
/// HᵀHλ ≥ 0 for the gaps g, so that −Hλ is the displacement to this position. Stores λ in work.lambda.
/// Returns false if there is no such position.
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
            "contact: at t = {:.6g} s the obstacles leave no room for the node at {}; move them apart", t,
            pairs.node_text(node.first)));
  });
}

void place_outside(const ContactPairs& pairs, Vec y) {
  if (pairs.skips_axis())
    if (const ContactPairs::Depth there = pairs.deepest_on_axis(y, 0); there.depth > pairs.gap_tolerance())
      throw UserError(
          fmt::format("{}: the node at {} on the axis starts {:.6g} m inside the obstacle; bodies must start "
                      "outside: move the body",
                      pairs.key(there.obstacle), point_text(there.x.data()), there.depth));
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
    if (const SurfacePair* surfaces = pairs.surfaces(obstacles[deepest]))
      throw UserError(fmt::format(
          "{}: the node at {} starts {:.6g} m inside the other part, as do {} of {} candidates. {}, or set "
          "contact.initial = \"project\", which moves such nodes out",
          pairs.key(obstacles[deepest]), pairs.node_text(deepest), -g[deepest], inside, all,
          surfaces->height() > 0
              ? fmt::format("Move a part, or lower contact.height, {:.6g} m", surfaces->height())
              : "Move a part"));
    // A reversed normal puts bodies deep inside; a face with otherwise rounded coordinates does not.
    constexpr double shallow = 1e-3; // part of the body's diameter
    const bool slight = -g[deepest] < shallow * pairs.diameter();
    const char* cure =
        slight ? "move the body, or set contact.initial = \"project\", which moves such nodes out"
        : inside == all && all > 1
            ? "move the body, or reverse the obstacle's normal, which must point out of the obstacle"
            : "move the body, reverse the obstacle's normal, which must point out of the obstacle, or set "
              "contact.initial = \"project\", which moves such nodes out";
    throw UserError(
        fmt::format("{}: the node at {} starts {:.6g} m inside the obstacle{}; bodies must start outside: {}",
                    pairs.key(obstacles[deepest]), pairs.node_text(deepest), -g[deepest],
                    inside == all && all > 1 ? fmt::format(", as do all {} candidates", all) : "", cure));
  }
  std::vector<int> slaves; // inside the other part; they alone move
  on_all_ranks(pairs.comm(), [&] {
    for (const ConstraintRows::Cluster& here : pairs.rows().clusters()) {
      if (pairs.mortar_row(here.first)) {
        if (g[here.first] < -allowed)
          slaves.push_back(here.first);
        continue;
      }
      if (std::all_of(&g[here.first], &g[here.first] + (here.last - here.first),
                      [&](double depth) { return depth >= -allowed; }))
        continue;
      if (!place(pairs, here, g, work))
        throw UserError(
            fmt::format("contact: the obstacles leave no room for the node at {}; move them apart",
                        pairs.node_text(here.first)));
      std::ranges::copy(work.lambda, &forces[here.first]);
    }
  });
  pairs.rows().apply(-1, forces, y);
  pairs.rows().prescribe(slaves, pairs.psi(), y);
}

} // namespace signorini::contact
