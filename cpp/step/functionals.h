// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"
#include "fem/sampler.h"
#include <span>
#include <string>
#include <utility>
#include <vector>

/// Linear functionals of a motion, shared by probes, measurements and BodyFigures: point values and means of
/// displacements and velocities, and forces of obstacles computed from contact multipliers.
namespace signorini::step {

/// Returns the rigid unit translation along an axis as a field of V. Collective.
[[nodiscard]] petsc::Vector translation(const fem::Space& space, std::size_t axis);

/// Mean of one component of a field y in V over a group or the body, as a functional: the mean is weights·y.
struct Mean {
  petsc::Vector weights;
  double measure; ///< e·Me with the matrix M of mean() and the unit translation e: area, volume or mass
};
/// Creates the mean of a component over a group or the body. `matrix`: the L2 product of the group, or a mass
/// matrix of the body. Collective.
[[nodiscard]] Mean mean(const fem::Space& space, Mat matrix, std::size_t component);

/// Throws UserError naming `key` if point `number` of `sampler` is farther from the mesh than 1 % of the
/// mesh's diameter. Nearer points count as inside the body, since a coarse mesh cuts off parts of a curved
/// body. `point`: its coordinates (m), for the message.
void require_inside(const fem::Space& space, const fem::Sampler& sampler, std::size_t number,
                    const std::vector<double>& point, const std::string& key);

/// Linear functional on V with few nonzero entries; stores those of this rank.
class SparseFunctional {
public:
  SparseFunctional() = default;
  explicit SparseFunctional(Vec functional);

  /// Returns this rank's contribution to the functional's value at y. `values`: the entries of y that this
  /// rank owns.
  [[nodiscard]] double operator()(std::span<const double> values) const;
  /// Adds factor times the functional's entries to `sum`, the owned entries of a vector of V.
  void add_to(std::span<double> sum, double factor) const;

private:
  std::vector<std::pair<int, double>> row_; ///< owned dofs, with the entry of each
};

/// Selects a component of the contact force on the body, from one obstacle or from all. With contact.against
/// it is the force on the part with the group contact.on.
struct ObstacleComponent {
  int obstacle = -1; ///< index in the scene; −1: the sum over all obstacles
  int component = 0;
};
/// Returns the selected component of the contact force on the body, in the unit of the multipliers `lambda`
/// (one for each row). `rows`: pairs.rows(), or their derivatives by a parameter. With derivatives, the
/// result is the derivative of the force at fixed multipliers. Not collective.
[[nodiscard]] double force_on_body(const contact::ContactPairs& pairs, const contact::ConstraintRows& rows,
                                   ObstacleComponent of, std::span<const double> lambda);
/// Adds factor times the derivative of the selected force component by the multipliers of pairs.rows() to
/// `dual` (one entry for each row). Not collective.
void add_force_dual(const contact::ContactPairs& pairs, ObstacleComponent of, double factor,
                    std::span<double> dual);

} // namespace signorini::step
