// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/surface_pair.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/text.h"
#include "contact/row_basis.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>
#include <utility>

namespace signorini::contact {

namespace {

/// Unclamped components of the nodes of a surface, one bit for each. Collective.
std::vector<int> free_components(const fem::Space& space, const fem::DirichletDofs& clamped,
                                 const fem::SurfaceMesh& surface) {
  std::map<PetscInt, std::size_t> number;
  std::vector<int> held(static_cast<std::size_t>(surface.nodes()));
  for (std::size_t i = 0; i < held.size(); ++i)
    number[surface.node(static_cast<int>(i)).first_dof] = i;
  for (const int dof : clamped.dofs())
    if (const auto found = number.find(space.first_dof() + dof / space.dim() * space.dim());
        found != number.end())
      held[found->second] |= 1 << dof % space.dim();
  MPI_Allreduce(MPI_IN_PLACE, held.data(), static_cast<int>(held.size()), MPI_INT, MPI_BOR, space.comm());
  for (int& bits : held)
    bits = ~bits & ((1 << space.dim()) - 1);
  return held;
}

/// Slave node that clamps hold along ν; null if there is none.
const fem::SurfaceMesh::Vertex* held_node(const fem::SurfaceMesh& slave, const std::vector<MortarRow>& rows,
                                          const std::vector<int>& free) {
  for (const MortarRow& row : rows) {
    double normal = 0;
    for (std::size_t c = 0; c < 3; ++c)
      if (free[static_cast<std::size_t>(row.vertex)] & (1 << c))
        normal = std::hypot(normal, row.nu[c]);
    if (normal <= RowBasis::dependence_limit)
      return &slave.vertices[static_cast<std::size_t>(row.vertex)];
  }
  return nullptr;
}

void refuse_common_nodes(const fem::SurfaceMesh& on, const fem::SurfaceMesh& against,
                         const scene::Contact& contact, const std::string& key) {
  std::set<PetscInt> nodes;
  for (const fem::SurfaceMesh::Vertex& vertex : on.vertices)
    nodes.insert(vertex.first_dof);
  for (const fem::SurfaceMesh::Vertex& vertex : against.vertices)
    if (nodes.contains(vertex.first_dof))
      throw UserError(fmt::format("{}.against: the groups \"{}\" and \"{}\" have the node at {} in common; "
                                  "choose groups without common nodes",
                                  key, contact.on, *contact.against, point_text(vertex.x.data())));
}

} // namespace

SurfacePair::SurfacePair(const fem::Space& space, const fem::DirichletDofs& clamped,
                         const scene::Contact& contact, const std::string& key)
    : slave_(fem::surface_mesh(space, contact.on, key + ".on")),
      master_(fem::surface_mesh(space, contact.against.value(), key + ".against")),
      slave_free_(contact::free_components(space, clamped, slave_)),
      master_free_(contact::free_components(space, clamped, master_)) {
  refuse_common_nodes(slave_, master_, contact, key);
  const int dim = space.dim();
  const auto exchange = [&] {
    std::swap(slave_, master_);
    std::swap(slave_free_, master_free_);
    side_ = side_ == scene::ContactSide::on ? scene::ContactSide::against : scene::ContactSide::on;
  };
  const auto find_rows = [&] {
    rows_ = mortar_rows(slave_, master_, dim, space.mesh().axisymmetric(), key);
    if (rows_.empty())
      throw UserError(fmt::format(
          "{}.against: no part of the group \"{}\" faces the group \"{}\" along its normals; choose "
          "surfaces that are opposite each other",
          key, contact.on, *contact.against));
    return held_node(slave_, rows_, slave_free_);
  };
  constexpr double rounding = 1e-9; // of facets that are equal on both sides, of which `on` has the slave
  if (contact.slave ? *contact.slave == scene::ContactSide::against
                    : contact::facet_size(master_, dim) < (1 - rounding) * contact::facet_size(slave_, dim))
    exchange();
  const fem::SurfaceMesh::Vertex* held = find_rows();
  if (held && !contact.slave)
    exchange(), held = find_rows(), exchanged_ = true;
  if (held)
    throw UserError(fmt::format(
        "{}.slave: a clamp holds the node at {} of the group \"{}\" towards the other part; {}", key,
        point_text(held->x.data()), side_ == scene::ContactSide::on ? contact.on : *contact.against,
        contact.slave ? "choose the other side" : "end the group before the clamp"));
  facet_size_ = contact::facet_size(slave_, dim);
  height_ = contact.height;
  slave_areas_ = hat_areas(slave_, dim, space.mesh().axisymmetric());
  master_areas_ = hat_areas(master_, dim, space.mesh().axisymmetric());
  for (const MortarRow& row : rows_)
    for (std::size_t c = 0; c < 3; ++c)
      towards_[c] += row.area * row.nu[c];
  const double length = std::hypot(towards_[0], towards_[1], towards_[2]);
  for (double& component : towards_)
    component = length > 0 ? component / length : 0;
  for (MortarRow& row : rows_)
    row.gap += contact.height * height_rate(row);
}

double SurfacePair::height_rate(const MortarRow& row) const {
  return -(row.nu[0] * towards_[0] + row.nu[1] * towards_[1] + row.nu[2] * towards_[2]);
}

void SurfacePair::append(const MortarRow& of, std::span<const double> direction,
                         std::vector<ConstraintRows::Entry>& row) const {
  const auto add = [&](const fem::SurfaceMesh& surface, const std::vector<int>& free, int node, double weight,
                       double lift) {
    for (std::size_t c = 0; c < direction.size(); ++c) // all components, since solvers take nodes as a whole
      row.push_back({surface.node(node).first_dof + static_cast<PetscInt>(c), weight * direction[c],
                     (free[static_cast<std::size_t>(node)] & (1 << c)) == 0, true, lift * direction[c]});
  };
  for (std::size_t c = 0; c < direction.size(); ++c) {
    row[c].coefficient = of.own * direction[c];
    row[c].lift = direction[c];
  }
  for (const auto& [node, weight] : of.slave) {
    const auto number = static_cast<std::size_t>(node);
    double hat = 0; // value of the hat function of the slave node
    if (number >= slave_.vertices.size())
      for (const int end : slave_.midpoints[number - slave_.vertices.size()].ends)
        hat += end == of.vertex ? 0.5 : 0;
    add(slave_, slave_free_, node, weight, hat);
  }
  for (const auto& [node, weight] : of.master)
    add(master_, master_free_, node, -weight, 0);
}

std::vector<PetscInt> SurfacePair::master_dofs() const {
  std::set<PetscInt> dofs;
  for (const MortarRow& row : rows_)
    for (const auto& [node, weight] : row.master)
      dofs.insert(master_.node(node).first_dof);
  return {dofs.begin(), dofs.end()};
}

} // namespace signorini::contact
