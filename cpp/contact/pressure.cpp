// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/pressure.h"
#include "base/collective.h"
#include <algorithm>
#include <map>

namespace signorini::contact {
using petsc::check;

namespace {

/// ∫ φ over an obstacle's group, for the node of each of the obstacle's candidates that this rank owns; 0 for
/// all other candidates.
std::vector<double> shares(const fem::Space& space, const ContactPairs& pairs, const std::string& group,
                           int obstacle) {
  const petsc::Matrix mass = fem::assemble_L2(space, group, pairs.key(obstacle) + ".on");
  const petsc::Vector one = space.vector(), sum = space.vector();
  check(VecSet(one, 1));
  check(MatMult(mass, one, sum));
  const petsc::ReadArray values(sum);
  std::vector<double> found(static_cast<std::size_t>(pairs.count()), 0.0);
  for (std::size_t j = 0; j < found.size(); ++j)
    if (const int dof = pairs.local_dofs()[j]; pairs.obstacles()[j] == obstacle && dof >= 0)
      found[j] = values[dof];
  return found;
}

} // namespace

std::vector<double> nodal_areas(const fem::Space& space, const ContactPairs& pairs,
                                const std::vector<scene::Contact>& contacts) {
  std::vector<double> areas(static_cast<std::size_t>(pairs.count()), 0.0);
  for (int i = 0; i < pairs.obstacle_count(); ++i)
    if (!pairs.surfaces(i))
      std::ranges::transform(areas, shares(space, pairs, contacts[i].on, i), areas.begin(), std::plus<>());
  MPI_Allreduce(MPI_IN_PLACE, areas.data(), static_cast<int>(areas.size()), MPI_DOUBLE, MPI_SUM,
                space.comm());
  for (std::size_t i = 0; i < areas.size(); ++i)
    if (const MortarRow* row = pairs.mortar_row(static_cast<int>(i)))
      areas[i] = row->area;
  return areas;
}

Pressure::Pressure(const fem::Space& space, const ContactPairs& pairs,
                   const std::vector<scene::Contact>& contacts)
    : area_(nodal_areas(space, pairs, contacts)) {
  for (std::size_t i = 0; i < area_.size(); ++i)
    if (const MortarRow* row = pairs.mortar_row(static_cast<int>(i)))
      area_[i] = pairs.surfaces(pairs.obstacles()[i])->slave_area(*row);
  for (int i = 0; i < pairs.obstacle_count() && space.degree() > 1; ++i)
    if (!pairs.surfaces(i)) // whose areas are those of hat functions
      add_edges(space, pairs, contacts[i].on, i);
  gather_at_vertices(area_);
  if (space.degree() > 1)
    clear_areas_off_edges(pairs);
}

void Pressure::clear_areas_off_edges(const ContactPairs& pairs) {
  std::vector<double> of_hats(area_.size(), 0.0);
  for (std::size_t i = 0; i < area_.size(); ++i)
    if (pairs.mortar_row(static_cast<int>(i)))
      of_hats[i] = area_[i];
  for (const Edge& edge : edges_)
    for (const int end : edge.ends)
      if (end >= 0)
        of_hats[end] = area_[end];
  area_ = std::move(of_hats);
}

void Pressure::add_edges(const fem::Space& space, const ContactPairs& pairs, const std::string& group,
                         int obstacle) {
  std::map<std::int64_t, int> candidate; // by node
  for (int j = 0; j < pairs.count(); ++j)
    if (pairs.obstacles()[j] == obstacle)
      candidate[pairs.first_dofs()[j] / space.dim()] = j;
  const auto candidate_at = [&](std::int64_t node) {
    const auto found = candidate.find(node);
    return found == candidate.end() ? -1 : found->second;
  };
  for (const fem::SurfaceEdge& nodes : fem::edges_on(space, group, pairs.key(obstacle) + ".on"))
    if (const int middle = candidate_at(nodes.middle); middle >= 0) {
      Edge edge{middle, {candidate_at(nodes.ends[0]), candidate_at(nodes.ends[1])}};
      for (const int end : {0, 1})
        if (const std::int64_t node =
                nodes.ends[static_cast<std::size_t>(end)] - space.first_dof() / space.dim();
            edge.ends[static_cast<std::size_t>(end)] < 0 && node >= 0 && node < space.owned_nodes() &&
            space.on_axis(static_cast<int>(node)))
          axis_.emplace_back(static_cast<int>(node), edge.ends[static_cast<std::size_t>(1 - end)]);
      if (space.mesh().axisymmetric()) // the other end takes the share of the axis
        edge.ends = {edge.ends[edge.ends[0] < 0 ? 1 : 0], edge.ends[edge.ends[1] < 0 ? 0 : 1]};
      edges_.push_back(edge);
    }
}

void Pressure::gather_at_vertices(std::vector<double>& values) const {
  for (const Edge& edge : edges_) {
    for (const int end : edge.ends)
      if (end >= 0)
        values[end] += values[edge.middle] / 2;
    values[edge.middle] = 0;
  }
}

std::vector<double> Pressure::operator()(std::span<const double> forces, double impulse) const {
  std::vector<double> lambda(forces.begin(), forces.end());
  gather_at_vertices(lambda);
  for (std::size_t i = 0; i < lambda.size(); ++i)
    lambda[i] = area_[i] > 0 ? lambda[i] / impulse / area_[i] : 0;
  for (const Edge& edge : edges_) {
    double sum = 0;
    int ends = 0;
    for (const int end : edge.ends)
      if (end >= 0 && area_[end] > 0) {
        sum += lambda[end];
        ++ends;
      }
    if (ends > 0)
      lambda[edge.middle] = sum / ends;
  }
  return lambda;
}

void Pressure::extend_to_axis(const std::vector<double>& pressures, std::vector<double>& field) const {
  for (const auto& [node, candidate] : axis_)
    if (candidate >= 0)
      field[static_cast<std::size_t>(node)] =
          std::max(field[static_cast<std::size_t>(node)], pressures[static_cast<std::size_t>(candidate)]);
}

namespace {

/// Tractions at the master nodes of contact between parts that this rank owns: (local node, Σ_i C_ij F_i / ∫
/// φ_j), for one contact after the other. `tractions`: F_i / ∫ φ_i of the candidates.
std::vector<std::pair<std::size_t, double>> at_masters(const fem::Space& space, const ContactPairs& pairs,
                                                       const std::vector<double>& tractions) {
  struct Sums {
    double force = 0, area = 0;
  };
  std::vector<std::pair<std::size_t, double>> found;
  for (int contact = 0; contact < pairs.obstacle_count(); ++contact) {
    const SurfacePair* surfaces = pairs.surfaces(contact);
    if (!surfaces)
      continue;
    std::map<PetscInt, Sums> at; // by the first dof of the master node
    for (int i = 0; i < pairs.count(); ++i)
      if (pairs.obstacles()[i] == contact) {
        const MortarRow& row = *pairs.mortar_row(i);
        const double force = surfaces->slave_area(row) * tractions[static_cast<std::size_t>(i)];
        surfaces->for_each_master_hat(
            row, [&](const fem::SurfaceMesh::Vertex& vertex, double weight, double area) {
              Sums& sums = at[vertex.first_dof];
              sums.force += weight * force;
              sums.area = area;
            });
      }
    for (const auto& [dof, sums] : at) {
      const PetscInt node = (dof - space.first_dof()) / space.dim();
      if (dof >= space.first_dof() && node < space.owned_nodes() && sums.area > 0)
        found.emplace_back(node, sums.force / sums.area);
    }
  }
  return found;
}

} // namespace

void extend_to_masters(const fem::Space& space, const ContactPairs& pairs,
                       const std::vector<double>& pressures, std::vector<double>& field) {
  for (const auto& [node, pressure] : at_masters(space, pairs, pressures))
    field[node] = std::max(field[node], pressure);
}

std::vector<double> at_nodes(const fem::Space& space, const ContactPairs& pairs,
                             const std::vector<double>& values) {
  std::vector<double> field(static_cast<std::size_t>(space.owned_nodes()), 0.0);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (const int dof = pairs.local_dofs()[i]; dof >= 0) {
      double& at = field[dof / space.dim()];
      at = std::max(at, values[i]);
    }
  return field;
}

std::vector<double> tangential_tractions(const ContactPairs& pairs, const Pressure& pressure,
                                         std::span<const double> rho, double impulse) {
  const ConstraintRows& rows = pairs.rows();
  const auto dim = static_cast<std::size_t>(pairs.dim()), m = static_cast<std::size_t>(pairs.count());
  std::vector<double> tractions(m * dim), forces(m);
  for (std::size_t component = 0; component < dim; ++component) {
    std::ranges::fill(forces, 0);
    for (std::size_t i = 0; i < m; ++i)
      for (std::size_t c = 1; c < rows.size(static_cast<int>(i)); ++c) {
        const std::size_t row = rows.row(static_cast<int>(i), c);
        forces[i] -= rows.lift(static_cast<int>(row))[component] * rho[row];
      }
    const std::vector<double> one = pressure(forces, impulse);
    for (std::size_t i = 0; i < m; ++i)
      tractions[i * dim + component] = one[i];
  }
  return tractions;
}

void set_friction(const fem::Space& space, const ContactPairs& pairs, const Pressure& pressure,
                  std::span<const double> rho, double impulse, Vec field) {
  const std::vector<double> tractions = tangential_tractions(pairs, pressure, rho, impulse);
  const auto dim = static_cast<std::size_t>(pairs.dim());
  petsc::check(VecZeroEntries(field));
  const petsc::WriteArray values(field);
  for (std::size_t i = 0; i < static_cast<std::size_t>(pairs.count()); ++i)
    if (const int dof = pairs.local_dofs()[i]; dof >= 0)
      for (std::size_t c = 0; c < dim; ++c)
        values[static_cast<std::size_t>(dof) + c] += tractions[i * dim + c];
  for (std::size_t c = 0; c < dim; ++c) {
    std::vector<double> along(static_cast<std::size_t>(pairs.count()));
    for (std::size_t i = 0; i < along.size(); ++i)
      along[i] = tractions[i * dim + c];
    for (const auto& [node, traction] : at_masters(space, pairs, along))
      values[dim * node + c] -= traction;
  }
}

} // namespace signorini::contact
