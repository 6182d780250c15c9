#include "contact/constraints.h"
#include "base/collective.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace signorini::contact {
namespace {

/// The numbers of every rank, in rank order, on every rank.
template <class T>
std::vector<T> gather(MPI_Comm comm, const std::vector<T>& mine, MPI_Datatype type) {
  const int size = ranks(comm);
  const int count = static_cast<int>(mine.size());
  std::vector<int> counts(size), offsets(size + 1);
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  std::partial_sum(counts.begin(), counts.end(), offsets.begin() + 1);
  std::vector<T> all(offsets.back());
  MPI_Allgatherv(mine.data(), count, type, all.data(), counts.data(), offsets.data(), type, comm);
  return all;
}

} // namespace

Constraints::Constraints(const fem::Space& space, const fem::Clamped& clamped, const scene::Contact& contact)
    : dim_(space.dim()), gap_tolerance_(1e-10 * space.mesh().diameter()), comm_(space.comm()) {
  std::vector<int> nodes = space.nodes_on(contact.on, "contact.on");
  std::erase_if(nodes, [&](int node) {
    for (int c = 0; c < dim_; ++c)
      if (!clamped.contains(node, c))
        return false;
    return true;
  });
  std::vector<double> x;
  std::vector<std::int64_t> first;
  for (int node : nodes) {
    x.insert(x.end(), &space.points()[3 * node], &space.points()[3 * node] + 3);
    first.push_back(space.first_dof() + node * dim_);
  }
  x = gather(comm_, x, MPI_DOUBLE);
  first = gather(comm_, first, MPI_INT64_T);
  const std::size_t m = first.size();
  if (m == 0)
    throw UserError(
        fmt::format("contact.on: every node of the group \"{}\" is clamped, allowed is a group with "
                    "nodes that can move",
                    contact.on));
  std::vector<std::size_t> order(m);
  std::iota(order.begin(), order.end(), 0);
  // Coordinates of a node may differ in the last digits from one partition of the mesh to another.
  const auto place = [&](double coordinate) { return std::llround(coordinate / gap_tolerance_); };
  std::ranges::sort(order, {}, [&](std::size_t i) {
    return std::array{place(x[3 * i]), place(x[3 * i + 1]), place(x[3 * i + 2])};
  });

  const std::vector<double>&point = contact.obstacle.point, &normal = contact.obstacle.normal;
  const double length = std::sqrt(std::inner_product(normal.begin(), normal.end(), normal.begin(), 0.0));
  for (std::size_t i : order) {
    points_.insert(points_.end(), &x[3 * i], &x[3 * i] + 3);
    first_dofs_.push_back(static_cast<PetscInt>(first[i]));
    double height = 0;
    for (int c = 0; c < dim_; ++c) {
      normals_.push_back(-normal[c] / length); // ν points into the obstacle, the obstacle's normal out of it
      height += normal[c] / length * (x[3 * i + c] - point[c]);
    }
    psi_.push_back(height);
  }
  const PetscInt end = space.first_dof() + space.owned_nodes() * dim_;
  for (PetscInt dof : first_dofs_)
    local_.push_back(dof >= space.first_dof() && dof < end ? static_cast<int>(dof - space.first_dof()) : -1);
}

void Constraints::normal_components(Vec x, std::span<double> out) const {
  std::ranges::fill(out, 0);
  {
    const petsc::ReadArray values(x);
    for (int i = 0; i < count(); ++i)
      for (int c = 0; local_[i] >= 0 && c < dim_; ++c)
        out[i] += normals_[i * dim_ + c] * values[local_[i] + c];
  }
  // Every entry comes from one rank alone, so the sum is exact and the same on all of them.
  MPI_Allreduce(MPI_IN_PLACE, out.data(), count(), MPI_DOUBLE, MPI_SUM, comm_);
}

void Constraints::gap(Vec y, std::span<double> out) const {
  normal_components(y, out);
  for (int i = 0; i < count(); ++i)
    out[i] = psi_[i] - out[i];
}

void Constraints::add_normal(double scale, std::span<const double> lambda, Vec x) const {
  const petsc::WriteArray values(x);
  for (int i = 0; i < count(); ++i)
    for (int c = 0; local_[i] >= 0 && c < dim_; ++c)
      values[local_[i] + c] += scale * lambda[i] * normals_[i * dim_ + c];
}

void Constraints::set_normal(std::span<const int> set, std::span<const double> value, Vec x) const {
  const petsc::WriteArray values(x);
  for (int i : set) {
    if (local_[i] < 0)
      continue;
    const double* nu = &normals_[i * dim_];
    double change = value[i];
    for (int c = 0; c < dim_; ++c)
      change -= nu[c] * values[local_[i] + c];
    for (int c = 0; c < dim_; ++c)
      values[local_[i] + c] += change * nu[c];
  }
}

void Constraints::require_outside(Vec y) const {
  std::vector<double> g(psi_.size());
  gap(y, g);
  const auto deepest = std::ranges::min_element(g);
  if (*deepest >= -gap_tolerance_)
    return;
  const double* x = &points_[3 * (deepest - g.begin())];
  throw UserError(fmt::format(
      "contact: the node at ({:.6g}, {:.6g}, {:.6g}) starts {:.6g} m inside the obstacle, allowed "
      "are bodies that start outside (the obstacle's normal points out of it)",
      x[0], x[1], x[2], -*deepest));
}

} // namespace signorini::contact
