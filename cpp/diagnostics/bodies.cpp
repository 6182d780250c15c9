// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/bodies.h"
#include "base/collective.h"
#include "diagnostics/balance.h"
#include "fem/coherence.h"
#include "step/functionals.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace signorini::diagnostics {
using petsc::check;

namespace {

/// Centre of mass and mass of each part. Collective.
std::vector<std::array<double, 4>> centers(const fem::Space& space, const fem::ConnectedParts& parts,
                                           std::span<const double> masses) {
  std::vector<std::array<double, 4>> sums(static_cast<std::size_t>(parts.count));
  for (std::size_t node = 0; node < parts.of_node.size(); ++node) {
    std::array<double, 4>& sum = sums[static_cast<std::size_t>(parts.of_node[node])];
    for (std::size_t c = 0; c < 3; ++c)
      sum[c] += masses[node] * space.points()[3 * node + c];
    sum[3] += masses[node];
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(4 * sums.size()), MPI_DOUBLE, MPI_SUM,
                space.comm());
  for (std::array<double, 4>& sum : sums)
    for (std::size_t c = 0; c < 3; ++c)
      sum[c] /= sum[3];
  return sums;
}

/// Number that all of the given owned nodes have; −1 if there are several, or no nodes. Collective.
int common(MPI_Comm comm, const std::vector<int>& nodes, const std::vector<int>& of_node) {
  std::array<int, 2> bounds{std::numeric_limits<int>::max(), std::numeric_limits<int>::max()}; // least, −most
  for (const int node : nodes) {
    const int number = of_node[static_cast<std::size_t>(node)];
    bounds = {std::min(bounds[0], number), std::min(bounds[1], -number)};
  }
  MPI_Allreduce(MPI_IN_PLACE, bounds.data(), 2, MPI_INT, MPI_MIN, comm);
  return bounds[0] == -bounds[1] ? bounds[0] : -1;
}

/// Number of the part that consists of the cells of a group; −1 if there is none. Collective.
int whole_part(const mesh::Mesh& mesh, const fem::ConnectedParts& parts, const std::string& group) {
  const std::vector<std::int32_t> owned = mesh.owned_cells();
  std::vector<std::int64_t> cells(2 * static_cast<std::size_t>(parts.count)); // in the group, in all
  for (const int part : parts.of_cell)
    ++cells[2 * static_cast<std::size_t>(part) + 1];
  for (const std::int32_t cell : mesh.cells(group, "mesh")) {
    const auto place = std::ranges::lower_bound(owned, cell) - owned.begin();
    ++cells[2 * static_cast<std::size_t>(parts.of_cell[static_cast<std::size_t>(place)])];
  }
  MPI_Allreduce(MPI_IN_PLACE, cells.data(), static_cast<int>(cells.size()), MPI_INT64_T, MPI_SUM,
                mesh.comm());
  int found = -1;
  for (int part = 0; part < parts.count; ++part) {
    const auto at = 2 * static_cast<std::size_t>(part);
    if (cells[at] == 0)
      continue;
    if (found >= 0 || cells[at] < cells[at + 1])
      return -1;
    found = part;
  }
  return found;
}

constexpr std::size_t per_body = 8; ///< sums: displacement and momentum by component, two energies

} // namespace

Bodies::Bodies(const step::Stepper& stepper, const std::vector<scene::Contact>& contacts)
    : stepper_(stepper), masses_(static_cast<std::size_t>(stepper.space().owned_nodes())) {
  const fem::Space& space = stepper.space();
  const auto dim = static_cast<std::size_t>(space.dim());
  {
    const std::size_t axis = dim - 1; // a translation along it is a rigid motion of every body
    const petsc::Vector one = step::translation(space, axis), product = space.vector();
    check(MatMult(stepper.operators().M, one, product));
    const petsc::ReadArray values(product);
    for (std::size_t node = 0; node < masses_.size(); ++node)
      masses_[node] = values[dim * node + axis];
  }
  const fem::ConnectedParts parts = fem::connected_parts(space);
  const std::vector<std::array<double, 4>> at = centers(space, parts, masses_);
  std::vector<int> order;
  const auto add = [&](int part) {
    if (part >= 0 && std::ranges::find(order, part) == order.end())
      order.push_back(part);
  };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const std::string key = scene::contact_key(contacts, i);
    add(common(space.comm(), space.nodes_on(contacts[i].on, key + ".on"), parts.of_node));
    if (contacts[i].against)
      add(common(space.comm(), space.nodes_on(*contacts[i].against, key + ".against"), parts.of_node));
  }
  std::vector<int> rest(static_cast<std::size_t>(parts.count));
  std::iota(rest.begin(), rest.end(), 0);
  std::ranges::sort(rest, {}, [&](int part) { return at[static_cast<std::size_t>(part)]; });
  std::ranges::for_each(rest, add);

  std::vector<int> number(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    number[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
    bodies_.push_back(
        {.name = fmt::format("body {}", i + 1), .mass = at[static_cast<std::size_t>(order[i])][3]});
  }
  for (const int part : parts.of_node)
    body_of_node_.push_back(number[static_cast<std::size_t>(part)]);
  std::vector<int> held(3 * bodies_.size());
  for (const int dof : stepper.clamped().dofs())
    held[3 * static_cast<std::size_t>(body_of_node_[static_cast<std::size_t>(dof) / dim]) +
         static_cast<std::size_t>(dof) % dim] = 1;
  MPI_Allreduce(MPI_IN_PLACE, held.data(), static_cast<int>(held.size()), MPI_INT, MPI_MAX, space.comm());
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      bodies_[i].clamped[c] = held[3 * i + c] != 0;
  for (const std::string& group : space.mesh().cell_groups())
    if (const int part = whole_part(space.mesh(), parts, group); part >= 0)
      bodies_[static_cast<std::size_t>(number[static_cast<std::size_t>(part)])].name = group;
  motions_.resize(bodies_.size());
  sums_.resize(per_body * bodies_.size());
}

int Bodies::of_group(const std::string& group, const std::string& key) const {
  return common(stepper_.space().comm(), stepper_.space().nodes_on(group, key), body_of_node_);
}

void Bodies::observe(const trajectory::Frame& frame, const Balance& balance) {
  std::ranges::fill(sums_, 0);
  const auto dim = static_cast<std::size_t>(stepper_.space().dim());
  {
    const petsc::ReadArray y(frame.after.y()), v(frame.after.v()), Mv(balance.momenta()),
        Ay(balance.elastic_forces());
    for (std::size_t node = 0; node < body_of_node_.size(); ++node) {
      double* sums = &sums_[per_body * static_cast<std::size_t>(body_of_node_[node])];
      for (std::size_t c = 0; c < dim; ++c) {
        const std::size_t i = dim * node + c;
        sums[c] += masses_[node] * y[i];
        sums[3 + c] += Mv[i];
        sums[6] += v[i] * Mv[i] / 2;
        sums[7] += y[i] * Ay[i] / 2;
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums_.data(), static_cast<int>(sums_.size()), MPI_DOUBLE, MPI_SUM,
                stepper_.space().comm());
  for (std::size_t body = 0; body < motions_.size(); ++body) {
    const double* sums = &sums_[per_body * body];
    BodyMotion& motion = motions_[body];
    for (std::size_t c = 0; c < dim; ++c)
      if (stepper_.space().translates(c)) {
        motion.displacement[c] = sums[c] / bodies_[body].mass;
        motion.momentum[c] = sums[3 + c];
      }
    motion.kinetic_energy = sums[6];
    motion.elastic_energy = sums[7];
  }
}

std::array<double, 3> Bodies::velocity(int body) const {
  std::array<double, 3> velocity = motions_[static_cast<std::size_t>(body)].momentum;
  for (double& component : velocity)
    component /= bodies_[static_cast<std::size_t>(body)].mass;
  return velocity;
}

} // namespace signorini::diagnostics
