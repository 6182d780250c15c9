// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"
#include "fem/sampler.h"
#include <span>
#include <string>
#include <utility>
#include <vector>

/// Linear functionals of a motion, shared by probes, measurements and figures of the body: point values and
/// means of displacements and velocities, and forces of obstacles from multipliers.
namespace signorini::step {

/// The translation by 1 along an axis, a field of V. Collective.
[[nodiscard]] petsc::Vector translation(const fem::Space& space, std::size_t axis);

/// Mean of one component of y in V, weights·y, over the set whose mass matrix gave the weights.
struct Mean {
  petsc::Vector weights;
  double measure; ///< e·Me for the translation e along the axis: area or volume, or mass
};
/// Makes the mean by `matrix`: that of the L2 product of a group, or a mass matrix. Collective.
[[nodiscard]] Mean mean(const fem::Space& space, Mat matrix, std::size_t component);

/// Throws UserError naming `key` if the point of this number is outside of the body: farther from its mesh
/// than chords of a coarse one are from a curved boundary.
void require_inside(const fem::Space& space, const fem::Sampler& sampler, std::size_t number,
                    const std::vector<double>& point, const std::string& key);

/// A functional of V in which few dofs have a part: its entries on this rank that are not zero.
class SparseFunctional {
public:
  SparseFunctional() = default;
  explicit SparseFunctional(Vec functional);

  /// Returns this rank's part of the value at y, whose owned entries are `values`.
  [[nodiscard]] double operator()(std::span<const double> values) const;
  /// sum += factor · functional, on the owned entries.
  void add_to(std::span<double> sum, double factor) const;

private:
  std::vector<std::pair<int, double>> row_; ///< owned dofs and weights
};

/// A component of the force on the body of one obstacle or of all.
struct ObstacleComponent {
  int obstacle = -1; ///< number in the scene; −1: all
  int component = 0;
};
/// Returns that component for multipliers `lambda`, in their unit. `rows`: pairs.rows() or, for the rate of
/// the force, their derivatives. Not collective.
[[nodiscard]] double force_on_body(const contact::ContactPairs& pairs, const contact::ConstraintRows& rows,
                                   ObstacleComponent of, std::span<const double> lambda);
/// dual += factor · derivative of that component by the multipliers of pairs.rows(). Not collective.
void add_force_dual(const contact::ContactPairs& pairs, ObstacleComponent of, double factor,
                    std::span<double> dual);

} // namespace signorini::step
