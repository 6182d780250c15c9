// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/time_profile.h"
#include "step/time_grid.h"
#include <optional>
#include <vector>

namespace signorini::step {

/// Returns the local number of the node at the point `at` (dim, m) on the rank that owns it, nothing on other
/// ranks. `key`: name of the force's table in messages. Collective. Throws UserError unless there is exactly
/// one node.
std::optional<std::size_t> node_at(const fem::Space& space, const std::vector<double>& at,
                                   const std::string& key);

/// Force of a scene on one node of the mesh or one virtual node, averaged over a step to the tolerance of
/// fem::TimeProfile.
class PointForce {
public:
  /// Finds the node. `key`: name of the table in messages; `end`: end of the motion, s. Collective. `space`
  /// must outlive this object. Throws UserError unless the mesh has one node at the point, and if a value is
  /// not finite.
  PointForce(const fem::Space& space, const scene::PointForce& force, const std::string& key, double end);
  /// Force `factor` · `value` on a virtual node (number), with `value` as expressions in t. `key`: key of
  /// `value` in messages. Collective. Throws UserError if a value is not finite.
  PointForce(const fem::Space& space, std::size_t virtual_node, const scene::Components& value, double factor,
             const std::string& key, double end);
  PointForce(const PointForce&) = delete; // profile_ refers to point_
  PointForce& operator=(const PointForce&) = delete;

  [[nodiscard]] const fem::TimeProfile& profile() const { return profile_; }
  /// Adds the mean force over the step, N (in plane strain and plane stress N/m), to `sum`.
  /// Collective.
  void add(const TimeStep& step, Vec sum) const;

private:
  std::size_t dim_;
  double factor_ = 1;
  std::optional<std::size_t> node_; ///< local number of the node; set on the rank that owns it
  std::vector<double> point_;       ///< the node's coordinates on that rank (0 if virtual), else empty
  fem::TimeProfile profile_;
  mutable std::vector<double> value_;
};

} // namespace signorini::step
