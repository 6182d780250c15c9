// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/rigid_body.h"
#include "base/collective.h"
#include "base/overloads.h"
#include <algorithm>

namespace signorini::contact {

namespace {

/// Value of a component of a quantity that is given by one number or by one for each component; 0 if absent.
double component(const std::vector<double>& given, std::size_t c) {
  return given.empty() ? 0 : given.size() == 1 ? given.front() : given[c];
}

/// Value of a point at t = 0, m (3).
std::vector<double> values_at_start(const scene::Components& point, const char* key) {
  std::vector<double> x(3);
  const std::array<double, 3> origin{};
  scene::Field(point, key, true).evaluate(origin.data(), 0, x.data());
  return x;
}

/// Centre of mass of an obstacle, m.
std::vector<double> mass_center(const scene::Contact& contact) {
  if (!contact.rigid->mass_center.empty())
    return contact.rigid->mass_center;
  return std::visit(
      Overloads{[](const scene::HalfSpace& plane) { return values_at_start(plane.point, "point"); },
                [](const scene::Ball& ball) { return values_at_start(ball.center, "center"); },
                [](const scene::Cylinder& cylinder) { return values_at_start(cylinder.point, "point"); },
                [](const scene::SignedDistance&) { return std::vector<double>(3); }},
      contact.obstacle.value());
}

} // namespace

std::vector<fem::VirtualNode> virtual_nodes(const std::vector<scene::Contact>& contacts, int dim,
                                            bool axisymmetric) {
  std::vector<fem::VirtualNode> nodes;
  for (const scene::Contact& contact : contacts) {
    if (!contact.rigid)
      continue;
    const scene::RigidBody& body = *contact.rigid;
    fem::VirtualNode& translation = nodes.emplace_back();
    for (std::size_t c = 0; c < static_cast<std::size_t>(dim); ++c) {
      translation.mass[c] = body.mass;
      translation.damping[c] = component(body.damping, c);
      translation.stiffness[c] = component(body.stiffness, c);
      translation.clamped[c] = !body.moves_along(static_cast<scene::Component>(c), axisymmetric);
    }
    if (body.inertia.empty())
      continue;
    fem::VirtualNode& rotation = nodes.emplace_back();
    for (std::size_t c = 0; c < static_cast<std::size_t>(dim); ++c) {
      rotation.clamped[c] = c >= body.inertia.size();
      rotation.mass[c] = rotation.clamped[c] ? 0 : body.inertia[c];
    }
  }
  return nodes;
}

std::size_t virtual_node(const std::vector<scene::Contact>& contacts, std::size_t contact) {
  std::size_t node = 0;
  for (std::size_t before = 0; before < contact; ++before)
    if (const auto& other = contacts[before].rigid)
      node += other->inertia.empty() ? 1 : 2;
  return node;
}

RigidMotion::RigidMotion(const fem::Space& space, const std::vector<scene::Contact>& contacts,
                         std::size_t contact)
    : space_(space) {
  const std::size_t node = virtual_node(contacts, contact);
  const scene::RigidBody& body = *contacts[contact].rigid;
  velocity_ = body.velocity;
  const std::vector<double> center = mass_center(contacts[contact]);
  std::ranges::copy(center, center_.begin());
  const auto dofs = [&](std::size_t of, std::size_t count) {
    std::vector<Dof> all;
    const PetscInt first = space.layout().first_dof_of_virtual(of);
    for (std::size_t c = 0; c < count; ++c)
      all.push_back({first + static_cast<PetscInt>(c), space.layout().virtual_nodes()[of].clamped[c]});
    return all;
  };
  translation_ = dofs(node, static_cast<std::size_t>(space.dim()));
  if (!body.inertia.empty())
    rotation_ = dofs(node + 1, translation_.size());
}

void RigidMotion::append(const double* x, std::span<const double> direction,
                         std::vector<ConstraintRows::Entry>& row) const {
  // With all dofs of a virtual node, since solvers take nodes as a whole.
  const auto add = [&](const Dof& at, double coefficient) {
    row.push_back({at.dof, at.fixed ? 0 : -coefficient, false, true});
  };
  std::array<double, 3> e{}, arm{};
  for (std::size_t c = 0; c < direction.size(); ++c) {
    e[c] = direction[c];
    arm[c] = x[c] - center_[c];
    add(translation_[c], e[c]);
  }
  // e·(θ × r) = θ·(r × e)
  const std::array<double, 3> moment{arm[1] * e[2] - arm[2] * e[1], arm[2] * e[0] - arm[0] * e[2],
                                     arm[0] * e[1] - arm[1] * e[0]};
  for (std::size_t c = 0; c < rotation_.size(); ++c)
    add(rotation_[c], moment[space_.dim() == 2 ? 2 : c]);
}

RigidMotion::Place RigidMotion::place(Vec y) const {
  Place place;
  if (space_.layout().owns_virtual_nodes()) {
    const petsc::ReadArray values(y);
    const auto value = [&](const Dof& at) {
      return values[static_cast<std::size_t>(at.dof - space_.first_dof())];
    };
    std::ranges::transform(translation_, place.translation.begin(), value);
    for (std::size_t c = 0; c < rotations(); ++c)
      place.rotation[space_.dim() == 2 ? 2 : c] = value(rotation_[c]);
  }
  MPI_Bcast(&place, sizeof(Place) / sizeof(double), MPI_DOUBLE, ranks(space_.comm()) - 1, space_.comm());
  return place;
}

std::array<double, 3> RigidMotion::displacement(const Place& at, const double* x) const {
  const std::array<double, 3>& turned = at.rotation;
  const std::array<double, 3> arm{x[0] - center_[0], x[1] - center_[1], x[2] - center_[2]};
  std::array<double, 3> moved = at.translation;
  for (std::size_t c = 0; c < 3; ++c)
    moved[c] += turned[(c + 1) % 3] * arm[(c + 2) % 3] - turned[(c + 2) % 3] * arm[(c + 1) % 3];
  return moved;
}

petsc::Vector RigidMotion::weights(std::size_t c) const {
  petsc::Vector made = space_.vector();
  const PetscInt dof = c < translation_.size() ? translation_[c].dof : rotation_[c - translation_.size()].dof;
  if (space_.layout().owns_virtual_nodes()) {
    const petsc::WriteArray values(made);
    values[static_cast<std::size_t>(dof - space_.first_dof())] = 1;
  }
  return made;
}

void RigidMotion::set_translation(std::span<const double> value, Vec of) const {
  if (!space_.layout().owns_virtual_nodes())
    return;
  const petsc::WriteArray values(of);
  for (std::size_t c = 0; c < translation_.size(); ++c)
    if (!translation_[c].fixed)
      values[static_cast<std::size_t>(translation_[c].dof - space_.first_dof())] = value[c];
}

void RigidMotion::set_velocity(Vec v) const {
  if (!velocity_.empty())
    set_translation(velocity_, v);
}

} // namespace signorini::contact
