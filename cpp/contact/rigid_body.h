// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "fem/space.h"
#include "scene/scene.h"
#include <optional>
#include <vector>

namespace signorini::contact {

/// Virtual nodes of the obstacles with mass: for each, in the order of the scene, one for its translation
/// and, if it turns, one for its rotation (docs/method.md section 2). In the plane the rotation about z is
/// component 0 of its node. `dim`: of the body; `axisymmetric`: whether it is one of revolution, whose
/// obstacles move along the axis alone.
[[nodiscard]] std::vector<fem::VirtualNode> virtual_nodes(const std::vector<scene::Contact>& contacts,
                                                          int dim, bool axisymmetric);

/// Number of the virtual node for the translation of an obstacle with mass; that for its rotation follows.
[[nodiscard]] std::size_t virtual_node(const std::vector<scene::Contact>& contacts, std::size_t contact);

/// Translation q and rotation θ of an obstacle with mass, as unknowns of a space.
class RigidMotion {
public:
  /// `contact`: number of the obstacle in `contacts`; it must have mass. `space`: with the virtual nodes of
  /// `contacts`; must outlive this object.
  RigidMotion(const fem::Space& space, const std::vector<scene::Contact>& contacts, std::size_t contact);

  /// Number of components of the rotation: 0 if it does not turn, 1 in the plane, 3 in space.
  [[nodiscard]] std::size_t rotations() const {
    return rotation_.empty() || translation_.size() == 3 ? rotation_.size() : 1;
  }
  /// Appends to a row with the direction e (dim) at the point x (3, m) the entries of −e·(q + θ × (x − x_c)),
  /// by which the row contains the motion of the body relative to that of the obstacle.
  void append(const double* x, std::span<const double> direction,
              std::vector<ConstraintRows::Entry>& row) const;
  /// Vector of V whose product with a displacement is component c of the translation or, from dim on, of the
  /// rotation. Collective.
  [[nodiscard]] petsc::Vector weights(std::size_t c) const;
  /// Translation (m) and rotation (rad) of an obstacle at one time.
  struct Place {
    std::array<double, 3> translation{}, rotation{};
  };
  /// Returns the place in a displacement y. Collective.
  [[nodiscard]] Place place(Vec y) const;
  /// Returns the displacement q + θ × (x − x_c) of the obstacle's point x (3, m).
  [[nodiscard]] std::array<double, 3> displacement(const Place& at, const double* x) const;

  /// Centre of mass of the obstacle where it starts, m.
  [[nodiscard]] const std::array<double, 3>& center() const { return center_; }
  /// Sets the translation of the obstacle in a vector of V to `value` (dim), its free components alone. Not
  /// collective.
  void set_translation(std::span<const double> value, Vec of) const;
  /// Sets the velocity v (a vector of V) of the obstacle to that at the start. Not collective.
  void set_velocity(Vec v) const;

private:
  /// Dof of a component and, if it is fixed, that it is.
  struct Dof {
    PetscInt dof;
    bool fixed;
  };
  const fem::Space& space_;
  std::array<double, 3> center_{};
  std::vector<double> velocity_; ///< at the start (dim), m/s; empty: at rest
  std::vector<Dof> translation_, rotation_;
};

} // namespace signorini::contact
