// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/pairs.h"
#include "base/collective.h"
#include "base/text.h"
#include "base/timers.h"
#include "contact/friction.h"
#include "contact/placement.h"
#include "contact/row_basis.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <utility>

namespace signorini::contact {

namespace {

long& made = count("constraints");

/// Unclamped components of a node, one bit for each.
int free_components(const fem::DirichletDofs& clamped, int node, int dim) {
  int free = 0;
  for (int c = 0; c < dim; ++c)
    free |= clamped.contains(node, c) ? 0 : 1 << c;
  return free;
}

} // namespace

ContactPairs::ContactPairs(const fem::Space& space, const fem::DirichletDofs& clamped,
                           const std::vector<scene::Contact>& contacts, const scene::Time& time)
    : dim_(space.dim()), axisymmetric_(space.mesh().axisymmetric()), diameter_(space.mesh().diameter()),
      gap_tolerance_(contact::gap_tolerance(diameter_)), comm_(space.comm()) {
  ++made;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    keys_.push_back(scene::contact_key(contacts, i));
    names_.push_back(contacts[i].name);
    project_.push_back(contacts[i].initial == scene::ContactStart::project);
    shapes_.emplace_back();
    surfaces_.emplace_back();
    if (contacts[i].against)
      surfaces_.back().emplace(space, clamped, contacts[i], keys_.back());
    else
      shapes_.back().emplace(contacts[i].obstacle.value(), keys_.back() + ".obstacle", dim_, diameter_,
                             space.mesh().axisymmetric());
    if (shapes_.back() && shapes_.back()->moves())
      moving_.push_back(i);
    rigid_.emplace_back();
    if (contacts[i].rigid)
      rigid_.back().emplace(space, contacts, i);
    friction_.emplace_back();
    if (contacts[i].frictional()) {
      const bool bounded = contacts[i].bound.has_value();
      friction_.back().emplace(
          scene::Components{bounded ? contacts[i].bound->traction : contacts[i].friction},
          keys_.back() + (bounded ? ".friction.bound" : ".friction"), true);
      friction_varies_ = friction_varies_ || friction_.back()->depends_on_time();
    }
    surface_velocity_.emplace_back();
    if (contacts[i].surface_velocity)
      surface_velocity_.back().emplace(*contacts[i].surface_velocity,
                                       keys_.back() + ".obstacle.surface_velocity", true);
  }
  add_pairs(contacts, space, clamped, time);
  if (std::ranges::any_of(contacts, [](const scene::Contact& contact) { return contact.bound.has_value(); }))
    set_tresca_areas(space, contacts);
  NodeWork work = node_work();
  require_room(*this, psi_, 0, work);
}

std::string ContactPairs::node_text(int i) const {
  return point_text(&points_[3 * static_cast<std::size_t>(i)]);
}

ContactPairs::NodeWork ContactPairs::node_work() const {
  std::size_t most = 0;
  for (const ConstraintRows::Cluster& cluster : rows().clusters())
    most = std::max(most, static_cast<std::size_t>(cluster.last - cluster.first));
  return NodeWork(most);
}

ContactPairs::Gaps ContactPairs::gaps() const {
  std::vector<Obstacle::Place> place;
  for (const std::optional<Obstacle>& shape : shapes_)
    place.push_back(shape ? shape->place(0) : Obstacle::Place{});
  return {
      .psi = std::vector<double>(moving() ? psi_.size() : 0), .place = std::move(place), .node = node_work()};
}

std::vector<ContactPairs::BoundaryNode>
ContactPairs::boundary_nodes(const std::vector<scene::Contact>& contacts, const fem::Space& space,
                             const fem::DirichletDofs& clamped) {
  std::vector<double> x;
  std::vector<std::int64_t> first;
  std::vector<int> kind; // for each: obstacle, free components
  for (std::size_t obstacle = 0; obstacle < contacts.size(); ++obstacle) {
    if (surfaces_[obstacle])
      continue;
    fem::require_area(space, contacts[obstacle].on, keys_[obstacle] + ".on");
    for (int node : space.nodes_on(contacts[obstacle].on, keys_[obstacle] + ".on", true)) {
      // On the axis a function of a vertex in degree 2 has no area, ∫ φ r dr = 0: a pressure exerts no force
      // there, which would be a permanent kink.
      if (space.degree() > 1 && space.on_axis(node)) {
        const double* at = &space.points()[3 * static_cast<std::size_t>(node)];
        axis_nodes_.push_back({{at[0], at[1], at[2]}, node * dim_, static_cast<int>(obstacle)});
        continue;
      }
      x.insert(x.end(), &space.points()[3 * node], &space.points()[3 * node] + 3);
      first.push_back(space.first_dof() + node * dim_);
      kind.push_back(static_cast<int>(obstacle));
      kind.push_back(free_components(clamped, node, dim_));
    }
  }
  int skipped = !axis_nodes_.empty();
  MPI_Allreduce(MPI_IN_PLACE, &skipped, 1, MPI_INT, MPI_MAX, comm_);
  skips_axis_ = skipped != 0;
  x = gather(comm_, x);
  first = gather(comm_, first);
  kind = gather(comm_, kind);
  std::vector<BoundaryNode> nodes;
  for (std::size_t i = 0; i < first.size(); ++i)
    nodes.push_back({{x[3 * i], x[3 * i + 1], x[3 * i + 2]}, first[i], kind[2 * i], kind[2 * i + 1]});
  for (std::size_t i = 0; i < surfaces_.size(); ++i)
    if (const SurfacePair* pair = surfaces(static_cast<int>(i)))
      for (const MortarRow& row : pair->rows())
        nodes.push_back({pair->node(row).x, pair->node(row).first_dof, static_cast<int>(i),
                         pair->free_components(row), &row});
  // Coordinates of a node may differ in the last digits from one partition of the mesh to another.
  const auto place = [&](double coordinate) { return std::llround(coordinate / gap_tolerance_); };
  std::ranges::sort(nodes, {}, [&](const BoundaryNode& node) {
    return std::array<std::int64_t, 5>{place(node.x[0]), place(node.x[1]), place(node.x[2]), node.first_dof,
                                       node.obstacle};
  });
  return nodes;
}

namespace {
constexpr int looks = 1000; // samples of an obstacle that moves, if step lengths are automatic
}

std::vector<double> ContactPairs::times_of_meeting(const std::vector<BoundaryNode>& nodes,
                                                   const scene::Time& time) const {
  std::vector<double> times(nodes.size()), before(nodes.size()),
      least(nodes.size(), std::numeric_limits<double>::infinity());
  for (std::size_t obstacle : moving_) {
    const Obstacle& shape = *shapes_[obstacle];
    const int steps = time.automatic() ? looks : time.steps;
    const double step = time.automatic() ? time.end / looks : time.step;
    for (int k = 0; shape.curved() && k <= steps; ++k) {
      const Obstacle::Place place = shape.place(k * step);
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (static_cast<std::size_t>(nodes[i].obstacle) != obstacle || nodes[i].free_components == 0 ||
            least[i] <= 0)
          continue;
        const double level = shape.level(nodes[i].x.data(), place), last = std::exchange(before[i], level);
        if (level < least[i])
          times[i] = place.t, least[i] = level;
        if (level <= 0 && k > 0) // between two steps, by the secant
          times[i] -= step * level / (level - last);
      }
    }
  }
  return times;
}

void ContactPairs::add_pairs(const std::vector<scene::Contact>& contacts, const fem::Space& space,
                             const fem::DirichletDofs& clamped, const scene::Time& time) {
  std::vector<int> candidates(contacts.size());
  std::vector<ConstraintRows::Group> groups;
  clamped_dofs_.resize(contacts.size());
  const std::vector<BoundaryNode> nodes = boundary_nodes(contacts, space, clamped);
  const std::vector<double> meeting = times_of_meeting(nodes, time);
  for (std::size_t number = 0; number < nodes.size(); ++number) {
    const BoundaryNode& node = nodes[number];
    const auto obstacle = static_cast<std::size_t>(node.obstacle);
    if (node.free_components == 0) {
      clamped_dofs_[obstacle].push_back(static_cast<PetscInt>(node.first_dof));
      continue;
    }
    const Obstacle::Plane plane = plane_of(node, meeting[number]);
    ConstraintRows::Group group;
    double free = 0;
    for (int c = 0; c < dim_; ++c) { // ν points into the obstacle, the obstacle's normal out of it
      const bool held = !(node.free_components & (1 << c));
      group.entries.push_back({static_cast<PetscInt>(node.first_dof) + c, -plane.normal[c], held});
      if (!held)
        free = std::hypot(free, plane.normal[c]);
    }
    if (free <= RowBasis::dependence_limit) { // the node cannot move towards the obstacle
      clamped_dofs_[obstacle].push_back(static_cast<PetscInt>(node.first_dof));
      continue;
    }
    for (const ConstraintRows::Entry& entry : group.entries)
      normals_.push_back(entry.coefficient);
    if (friction_[obstacle]) {
      group.law = contacts[obstacle].bound ? static_cast<const Law*>(&tresca) : &coulomb;
      add_tangents(node, group);
    }
    append_opposite(node, group);
    groups.push_back(std::move(group));
    points_.insert(points_.end(), node.x.begin(), node.x.end());
    psi_.push_back(meeting[number] == 0 ? plane.height : plane_of(node, 0).height);
    first_dofs_.push_back(static_cast<PetscInt>(node.first_dof));
    obstacles_.push_back(node.obstacle);
    mortar_.push_back(node.row);
    ++candidates[obstacle];
  }
  for (std::vector<PetscInt>& dofs : clamped_dofs_)
    std::ranges::sort(dofs);
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (candidates[i] == 0)
      throw UserError(fmt::format("{}.on: every node of the group \"{}\" is clamped in the direction of the "
                                  "obstacle; choose a group with nodes that can move towards it",
                                  keys_[i], contacts[i].on));
  const PetscInt end = space.first_dof() + space.layout().nodes() * dim_;
  for (PetscInt dof : first_dofs_)
    local_.push_back(dof >= space.first_dof() && dof < end ? static_cast<int>(dof - space.first_dof()) : -1);
  rows_.emplace(comm_, groups, space.first_dof(), end);
  if (!rows_->symmetric()) {
    friction_at_start_.resize(psi_.size());
    evaluate_friction(0, friction_at_start_);
  }
  on_all_ranks(comm_, [&] { refuse_common_nodes(); });
}

Obstacle::Plane ContactPairs::plane_of(const BoundaryNode& node, double meeting) const {
  if (node.row)
    return {.normal = {-node.row->nu[0], -node.row->nu[1], -node.row->nu[2]}, .height = node.row->gap};
  const Obstacle& shape = *shapes_[static_cast<std::size_t>(node.obstacle)];
  return shape.at(node.x.data(), shape.place(meeting));
}

void ContactPairs::refuse_common_nodes() const {
  const auto refuse_several = [&](const auto& alone, const char* key, const char* reason) {
    for (const ConstraintRows::Cluster& node : rows_->clusters())
      for (int i = node.first; node.last - node.first > 1 && i < node.last; ++i)
        if (alone[obstacles_[i]])
          throw UserError(
              fmt::format("{}.{}: the node at {} is a candidate of {}; choose groups without common nodes",
                          keys_[obstacles_[i]], key, node_text(i), reason));
  };
  refuse_several(rigid_, "on", "another obstacle too, which obstacles with mass do not permit");
  refuse_several(surfaces_, "on", "another contact too, which contact.against does not permit");
  if (std::ranges::any_of(friction_, [](const auto& friction) { return friction.has_value(); })) {
    refuse_several(friction_, "friction", "several obstacles, where friction is not possible");
    for (const ConstraintRows::Cluster& node : rows_->clusters())
      if (node.dependent)
        throw UserError(fmt::format(
            "contact: the normals of the obstacles at the node at {} depend on each other, which friction "
            "does not permit; choose groups without common nodes",
            node_text(node.first)));
  }
  std::map<PetscInt, int> candidate; // by the first dof of its node
  for (int i = 0; i < count(); ++i)
    candidate[first_dofs_[i]] = i;
  for (std::size_t number = 0; number < surfaces_.size(); ++number)
    if (surfaces_[number])
      for (const PetscInt dof : surfaces_[number]->master_dofs())
        if (const auto found = candidate.find(dof); found != candidate.end())
          throw UserError(fmt::format(
              "{}.against: the node at {} is a candidate of \"{}\" and opposite candidates of \"{}\"; choose "
              "groups without common nodes, or another slave side",
              keys_[number], node_text(found->second),
              names_[static_cast<std::size_t>(obstacles_[found->second])], names_[number]));
}

void ContactPairs::set_rigid_velocities(Vec v) const {
  for (const std::optional<RigidMotion>& motion : rigid_)
    if (motion)
      motion->set_velocity(v);
}

void ContactPairs::append_opposite(const BoundaryNode& node, ConstraintRows::Group& group) const {
  const RigidMotion* motion = rigid(node.obstacle);
  const auto append = [&](std::vector<ConstraintRows::Entry>& row) {
    std::vector<double> direction;
    for (const ConstraintRows::Entry& entry : row)
      direction.push_back(entry.coefficient);
    if (motion)
      motion->append(node.x.data(), direction, row);
    if (node.row)
      surfaces(node.obstacle)->append(*node.row, direction, row);
  };
  append(group.entries);
  for (std::vector<ConstraintRows::Entry>& row : group.others)
    append(row);
}

std::optional<ConstraintRows> ContactPairs::jumps(const fem::Space& space) const {
  const auto dim = static_cast<std::size_t>(dim_);
  std::vector<ConstraintRows::Group> groups;
  for (int i = 0; i < count(); ++i)
    for (std::size_t axis = 0; mortar_row(i) && axis < dim; ++axis) {
      std::vector<double> direction(dim);
      direction[axis] = 1;
      ConstraintRows::Group& group = groups.emplace_back();
      for (int c = 0; c < dim_; ++c)
        group.entries.push_back({first_dofs_[static_cast<std::size_t>(i)] + c, direction[c], false});
      surfaces(obstacles_[i])->append(*mortar_row(i), direction, group.entries);
    }
  if (groups.empty())
    return {};
  return ConstraintRows(comm_, groups, space.first_dof(), space.first_dof() + space.layout().nodes() * dim_);
}

ContactPairs::Rates ContactPairs::rates(int obstacle, const scene::ObstacleRate& rate) const {
  const auto m = static_cast<std::size_t>(count()), dim = static_cast<std::size_t>(dim_);
  Rates rates{.psi = std::vector<double>(m), .rows = {}};
  if (const SurfacePair* pair = surfaces(obstacle)) {
    for (std::size_t i = 0; i < m; ++i)
      if (obstacles_[i] == obstacle)
        rates.psi[i] = rate.height * pair->height_rate(*mortar_[i]);
    return rates;
  }
  std::vector<double> coefficients; // of the rows
  const Obstacle& shape = *shapes_[obstacle];
  const Obstacle::Place place = shape.place(0);
  bool turns = false;
  for (std::size_t i = 0; i < m; ++i) {
    std::vector<double> turned(dim);
    if (obstacles_[i] == obstacle) {
      const Obstacle::Plane change = shape.derivative(&points_[3 * i], place, rate);
      rates.psi[i] = change.height;
      for (std::size_t c = 0; c < dim; ++c) {
        turned[c] = -change.normal[c];
        turns |= change.normal[c] != 0;
      }
    }
    const std::size_t begin = coefficients.size();
    coefficients.insert(coefficients.end(), turned.begin(), turned.end());
    if (const RigidMotion* motion = rigid(obstacles_[i])) {
      std::vector<ConstraintRows::Entry> of_rigid;
      motion->append(&points_[3 * i], turned, of_rigid);
      for (const ConstraintRows::Entry& entry : of_rigid)
        coefficients.push_back(entry.coefficient);
    }
    if (mortar_[i]) // its direction is that of another contact
      coefficients.resize(begin + rows_->columns(static_cast<int>(i)).size());
  }
  if (turns)
    rates.rows = rows().with(std::move(coefficients));
  return rates;
}

void ContactPairs::set_time(int obstacle, const scene::ObstacleRate& rate, double t, Rates& rates) const {
  if (!shapes_[obstacle] || !shapes_[obstacle]->moves())
    return;
  const Obstacle& shape = *shapes_[obstacle];
  const Obstacle::Place place = shape.place(t);
  for (std::size_t i = 0; i < rates.psi.size(); ++i)
    if (obstacles_[i] == obstacle)
      rates.psi[i] = shape.derivative(&points_[3 * i], place, rate).height;
}

std::span<const double> ContactPairs::psi(double t, Gaps& gaps) const {
  if (!moving())
    return psi_;
  for (std::size_t obstacle : moving_)
    gaps.place[obstacle] = shapes_[obstacle]->place(t);
  for (std::size_t i = 0; i < psi_.size(); ++i) {
    const Obstacle* shape = obstacle(static_cast<int>(i));
    gaps.psi[i] = shape && shape->moves()
                      ? shape->at(&points_[3 * i], gaps.place[static_cast<std::size_t>(obstacles_[i])]).height
                      : psi_[i];
  }
  require_room(*this, gaps.psi, t, gaps.node);
  return gaps.psi;
}

ContactPairs::Depth ContactPairs::deepest_on_axis(Vec y, double t) const {
  std::vector<Depth> mine(1);
  {
    const petsc::ReadArray values(y);
    for (const AxisNode& node : axis_nodes_) {
      const Obstacle& shape = *shapes_[static_cast<std::size_t>(node.obstacle)];
      std::array<double, 3> x = node.x;
      x[1] += values[static_cast<std::size_t>(node.local_dof) + 1];
      if (const double depth = shape.depth(x.data(), shape.place(t)); depth > mine[0].depth)
        mine[0] = {depth, node.obstacle, node.x};
    }
  }
  const std::vector<Depth> all = gather(comm_, mine);
  return *std::ranges::max_element(all, {}, &Depth::depth);
}

} // namespace signorini::contact
