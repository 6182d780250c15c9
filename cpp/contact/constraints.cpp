#include "contact/constraints.h"
#include "base/collective.h"
#include "base/counters.h"
#include "base/text.h"
#include "contact/node_basis.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <numeric>

namespace signorini::contact {
namespace {

long& made = count("constraints");

/// The components of a node that no clamp holds, one bit each.
int free_components(const fem::DirichletDofs& clamped, int node, int dim) {
  int free = 0;
  for (int c = 0; c < dim; ++c)
    free |= clamped.contains(node, c) ? 0 : 1 << c;
  return free;
}

} // namespace

Constraints::Constraints(const fem::Space& space, const fem::DirichletDofs& clamped,
                         const std::vector<scene::Contact>& contacts)
    : dim_(space.dim()), diameter_(space.mesh().diameter()), gap_tolerance_(1e-10 * diameter_),
      comm_(space.comm()) {
  ++made;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    keys_.push_back(scene::contact_key(contacts, i));
    project_.push_back(contacts[i].initial == scene::ContactStart::project);
    shapes_.emplace_back(contacts[i].obstacle, keys_.back() + ".obstacle", dim_, diameter_);
    if (shapes_.back().moves())
      moving_.push_back(i);
  }
  add_candidates(contacts, space, clamped);
  group_by_node();
  if (moving())
    now_.resize(psi_.size());
  advance_.resize(shapes_.size());
  require_room(psi_, 0);
}

void Constraints::add_candidates(const std::vector<scene::Contact>& contacts, const fem::Space& space,
                                 const fem::DirichletDofs& clamped) {
  std::vector<double> x;
  std::vector<std::int64_t> first;
  std::vector<int> kind; // for each: obstacle, free components
  for (std::size_t obstacle = 0; obstacle < contacts.size(); ++obstacle)
    for (int node : space.nodes_on(contacts[obstacle].on, keys_[obstacle] + ".on")) {
      x.insert(x.end(), &space.points()[3 * node], &space.points()[3 * node] + 3);
      first.push_back(space.first_dof() + node * dim_);
      kind.push_back(static_cast<int>(obstacle));
      kind.push_back(free_components(clamped, node, dim_));
    }
  x = gather(comm_, x);
  first = gather(comm_, first);
  kind = gather(comm_, kind);
  std::vector<std::size_t> order(first.size());
  std::iota(order.begin(), order.end(), 0);
  // Coordinates of a node may differ in the last digits from one partition of the mesh to another.
  const auto place = [&](double coordinate) { return std::llround(coordinate / gap_tolerance_); };
  std::ranges::sort(order, {}, [&](std::size_t i) {
    return std::array<std::int64_t, 5>{place(x[3 * i]), place(x[3 * i + 1]), place(x[3 * i + 2]), first[i],
                                       kind[2 * i]};
  });

  std::vector<int> candidates(contacts.size());
  clamped_dofs_.resize(contacts.size());
  for (std::size_t i : order) {
    const auto obstacle = static_cast<std::size_t>(kind[2 * i]);
    if (kind[2 * i + 1] == 0) {
      clamped_dofs_[obstacle].push_back(static_cast<PetscInt>(first[i]));
      continue;
    }
    const Obstacle::Plane plane = shapes_[obstacle].at(&x[3 * i]);
    std::array<double, 3> force{};
    double free = 0;
    for (int c = 0; c < dim_; ++c)
      if (kind[2 * i + 1] & (1 << c)) {
        force[c] = -plane.normal[c]; // ν points into the obstacle, the obstacle's normal out of it
        free = std::hypot(free, force[c]);
      }
    if (free <= NodeBasis::parallel) { // the node cannot move towards the obstacle
      clamped_dofs_[obstacle].push_back(static_cast<PetscInt>(first[i]));
      continue;
    }
    held_ |= kind[2 * i + 1] != (1 << dim_) - 1;
    for (int c = 0; c < dim_; ++c) {
      normals_.push_back(-plane.normal[c]);
      directions_.push_back(force[c]);
    }
    points_.insert(points_.end(), &x[3 * i], &x[3 * i] + 3);
    psi_.push_back(plane.height);
    first_dofs_.push_back(static_cast<PetscInt>(first[i]));
    obstacles_.push_back(kind[2 * i]);
    ++candidates[obstacle];
  }
  for (std::vector<PetscInt>& dofs : clamped_dofs_)
    std::ranges::sort(dofs);
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (candidates[i] == 0)
      throw UserError(fmt::format(
          "{}.on: every node of the group \"{}\" is clamped against the obstacle, allowed is a group "
          "with nodes that can move towards it",
          keys_[i], contacts[i].on));
  const PetscInt end = space.first_dof() + space.owned_nodes() * dim_;
  for (PetscInt dof : first_dofs_)
    local_.push_back(dof >= space.first_dof() && dof < end ? static_cast<int>(dof - space.first_dof()) : -1);
}

void Constraints::group_by_node() {
  int largest = 0;
  for (int i = 0; i < count();) {
    Node node{i, i, false};
    NodeBasis basis(dim_);
    for (; node.last < count() && first_dofs_[node.last] == first_dofs_[i]; ++node.last) {
      nodes_.push_back(static_cast<int>(per_node_.size()));
      node.crowded |= !basis.add(direction(node.last));
    }
    largest = std::max(largest, node.last - node.first);
    dependent_ |= node.crowded;
    per_node_.push_back(node);
    i = node.last;
  }
  const auto size = static_cast<std::size_t>(largest);
  work_.solver = DualActiveSet(size);
  work_.gram.reserve(size * size);
  work_.lambda.reserve(size);
  work_.set.reserve(size);
}

std::string Constraints::shown(int i) const { return point_text(&points_[3 * static_cast<std::size_t>(i)]); }

std::span<const double> Constraints::psi(double t) const {
  if (!moving())
    return psi_;
  for (std::size_t obstacle : moving_)
    advance_[obstacle] = shapes_[obstacle].advance(t);
  for (std::size_t i = 0; i < psi_.size(); ++i)
    now_[i] = psi_[i] - advance_[static_cast<std::size_t>(obstacles_[i])];
  require_room(now_, t);
  return now_;
}

bool Constraints::place(const Node& node, std::span<const double> gap) const {
  const auto size = static_cast<std::size_t>(node.last - node.first);
  work_.gram.clear();
  for (int i = node.first; i < node.last; ++i)
    for (int j = node.first; j < node.last; ++j)
      work_.gram.push_back(std::inner_product(direction(i), direction(i) + dim_, direction(j), 0.0));
  work_.lambda.resize(size);
  const auto depends = [this, &node](const ActiveSet& set, int j) {
    NodeBasis basis(dim_);
    for (int i : set)
      basis.add(direction(node.first + i));
    return !basis.add(direction(node.first + j));
  };
  int steps = 0;
  return work_.solver.solve(work_.gram, gap.subspan(static_cast<std::size_t>(node.first), size),
                            gap_tolerance_, std::cref(depends), work_.set, work_.lambda, steps);
}

void Constraints::require_room(std::span<const double> psi, double t) const {
  if (held_) // whether there is room depends on the motion of the clamps too
    return;
  if (!dependent_)
    return;
  together(comm_, [&] {
    for (const Node& node : per_node_)
      if (node.crowded && !place(node, psi))
        throw UserError(fmt::format(
            "contact: at t = {:.6g} s the obstacles leave no room for the node at {}, allowed are "
            "obstacles between which every node has a place",
            t, shown(node.first)));
  });
}

void Constraints::normal_components(Vec x, std::span<double> out) const {
  std::ranges::fill(out, 0);
  {
    const petsc::ReadArray values(x);
    for (int i = 0; i < count(); ++i)
      for (int c = 0; local_[i] >= 0 && c < dim_; ++c)
        out[i] += normals_[i * dim_ + c] * values[local_[i] + c];
  }
  // Every entry comes from one rank alone, so the sum is exact and the same on every rank.
  MPI_Allreduce(MPI_IN_PLACE, out.data(), count(), MPI_DOUBLE, MPI_SUM, comm_);
}

void Constraints::gap(std::span<const double> psi, Vec y, std::span<double> out) const {
  normal_components(y, out);
  for (int i = 0; i < count(); ++i)
    out[i] = psi[i] - out[i];
}

void Constraints::add_normal(double scale, std::span<const double> lambda, Vec x) const {
  add(scale, lambda, directions_, x);
}

void Constraints::add_whole(double scale, std::span<const double> lambda, Vec x) const {
  add(scale, lambda, normals_, x);
}

void Constraints::add(double scale, std::span<const double> lambda, const std::vector<double>& directions,
                      Vec x) const {
  const petsc::WriteArray values(x);
  for (int i = 0; i < count(); ++i)
    for (int c = 0; local_[i] >= 0 && c < dim_; ++c)
      values[local_[i] + c] += scale * lambda[i] * directions[i * dim_ + c];
}

void Constraints::forces(const ActiveSet& set, Vec x, std::span<double> lambda) const {
  std::ranges::fill(lambda, 0);
  {
    const petsc::ReadArray values(x);
    const std::span<const double> all = values;
    NodeBasis basis(dim_);
    std::array<int, 3> members{};
    for (auto at = set.begin(); at != set.end();) {
      const Node& here = node(*at);
      basis.clear();
      for (; at != set.end() && *at < here.last; ++at)
        if (basis.add(direction(*at)))
          members[basis.size() - 1] = *at;
      if (local_[here.first] < 0)
        continue;
      std::array<double, 3> b{};
      for (std::size_t k = 0; k < basis.size(); ++k)
        b[k] = basis.along(k, &all[local_[here.first]]);
      basis.combine(b);
      for (std::size_t k = 0; k < basis.size(); ++k)
        lambda[members[k]] = b[k];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, lambda.data(), count(), MPI_DOUBLE, MPI_SUM, comm_); // exact, as above
}

void Constraints::set_normal(std::span<const int> set, std::span<const double> value, Vec x) const {
  const petsc::WriteArray values(x);
  const std::span<double> all = values;
  NodeBasis basis(dim_);
  for (auto at = set.begin(); at != set.end();) {
    const Node& here = node(*at);
    if (local_[here.first] < 0) {
      at = std::find_if(at, set.end(), [&](int i) { return i >= here.last; });
      continue;
    }
    double* at_node = &all[local_[here.first]];
    basis.clear();
    std::array<double, 3> change{};
    for (; at != set.end() && *at < here.last; ++at)
      if (basis.add(direction(*at))) {
        const double* nu = &normals_[*at * dim_];
        change[basis.size() - 1] = value[*at] - std::inner_product(nu, nu + dim_, at_node, 0.0);
      }
    basis.shortest(change);
    basis.add_to(at_node, change);
  }
}

void Constraints::hold(Vec diagonal, Vec r, Vec y) const {
  if (!held_)
    return;
  const petsc::ReadArray d(diagonal), force(r);
  const petsc::WriteArray values(y);
  for (int i = 0; i < count(); ++i)
    for (int c = 0; local_[i] >= 0 && c < dim_; ++c)
      if (directions_[i * dim_ + c] != normals_[i * dim_ + c])
        values[local_[i] + c] = force[local_[i] + c] / d[local_[i] + c];
}

double Constraints::held_normal(int i, std::span<const double> y) const {
  double sum = 0;
  for (int c = 0; c < dim_; ++c)
    sum += (normals_[i * dim_ + c] - directions_[i * dim_ + c]) * y[local_[i] + c];
  return sum;
}

bool Constraints::depends(const ActiveSet& set, int i) const {
  const Node& here = node(i);
  if (!here.crowded)
    return false;
  NodeBasis basis(dim_);
  for (auto at = std::ranges::lower_bound(set, here.first); at != set.end() && *at < here.last; ++at)
    basis.add(direction(*at));
  return !basis.add(direction(i));
}

void Constraints::drop_dependent(ActiveSet& set) const {
  if (!dependent())
    return;
  NodeBasis basis(dim_);
  int last = 0;
  std::erase_if(set, [&](int i) {
    if (i >= last) {
      basis.clear();
      last = node(i).last;
    }
    return !basis.add(direction(i));
  });
}

void Constraints::next_set(const ActiveSet& set, std::span<const double> lambda, std::span<const double> gap,
                           ActiveSet& next) const {
  next.clear();
  auto at = set.begin();
  for (const Node& here : per_node_) {
    const std::size_t begin = next.size();
    for (int i = here.first; i < here.last; ++i) {
      const bool closed = at != set.end() && *at == i;
      at += closed;
      if (closed ? lambda[i] > 0 : gap[i] < 0)
        next.push_back(i);
    }
    if (here.crowded)
      exchange(lambda, next, begin);
  }
}

void Constraints::exchange(std::span<const double> lambda, ActiveSet& set, std::size_t begin) const {
  NodeBasis basis(dim_);
  std::array<int, 3> members{};
  for (const bool pushes : {true, false}) // closed candidates with forces are independent
    for (std::size_t at = begin; at < set.size(); ++at) {
      const int i = set[at];
      if ((lambda[i] > 0) != pushes)
        continue;
      if (basis.add(direction(i))) {
        members[basis.size() - 1] = i;
        continue;
      }
      std::array<double, 3> part{}; // coefficients of the members in the direction of i
      for (std::size_t k = 0; k < basis.size(); ++k)
        part[k] = basis.along(k, direction(i));
      basis.combine(part);
      std::size_t leaves = basis.size();
      for (std::size_t k = 0; k < basis.size(); ++k)
        if (part[k] > NodeBasis::parallel &&
            (leaves == basis.size() || lambda[members[k]] * part[leaves] < lambda[members[leaves]] * part[k]))
          leaves = k;
      if (leaves == basis.size() || lambda[members[leaves]] == 0) // it was just added, with no force
        continue;
      members[leaves] = i;
      const std::size_t size = basis.size();
      basis.clear();
      for (std::size_t k = 0; k < size; ++k)
        if (basis.add(direction(members[k])))
          members[basis.size() - 1] = members[k];
    }
  set.resize(begin);
  set.insert(set.end(), members.begin(), members.begin() + static_cast<std::ptrdiff_t>(basis.size()));
  std::sort(set.begin() + static_cast<std::ptrdiff_t>(begin), set.end());
}

void Constraints::take_node(const ActiveSet& other, int i, ActiveSet& set) const {
  const Node& here = node(i);
  const auto part = [&](auto& all) {
    return std::pair{std::ranges::lower_bound(all, here.first), std::ranges::lower_bound(all, here.last)};
  };
  const auto [first, last] = part(set);
  const auto [from, to] = part(other);
  set.insert(set.erase(first, last), from, to);
}

void Constraints::place_outside(Vec y) const {
  std::vector<double> g(psi_.size()), forces(psi_.size());
  gap(psi_, y, g);
  int deepest = -1;
  for (int i = 0; i < count(); ++i)
    if (g[i] < -gap_tolerance_ && !project_[obstacles_[i]] && (deepest < 0 || g[i] < g[deepest]))
      deepest = i;
  if (deepest >= 0)
    throw UserError(fmt::format(
        "{}: the node at {} starts {:.6g} m inside the obstacle, allowed are bodies that start outside (the "
        "obstacle's normal points out of it) and initial = \"project\", which moves such nodes out of it",
        keys_[obstacles_[deepest]], shown(deepest), -g[deepest]));
  together(comm_, [&] {
    for (const Node& here : per_node_) {
      if (std::all_of(&g[here.first], &g[here.first] + (here.last - here.first),
                      [&](double depth) { return depth >= -gap_tolerance_; }))
        continue;
      if (!place(here, g))
        throw UserError(
            fmt::format("contact: the obstacles leave no room for the node at {}, allowed are obstacles "
                        "between which every node has a place",
                        shown(here.first)));
      std::ranges::copy(work_.lambda, &forces[here.first]);
    }
  });
  add_normal(-1, forces, y);
}

} // namespace signorini::contact
