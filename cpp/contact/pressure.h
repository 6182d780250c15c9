// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"
#include <array>
#include <vector>

namespace signorini::contact {

/// Returns ∫ φ_i over its obstacle's contact surface for each candidate (m entries), in m in the plane, m² in
/// axial symmetry and in space; with contact.against over the part that the other surface covers. Of degree 2
/// in space it vanishes at vertices. Collective.
[[nodiscard]] std::vector<double> nodal_areas(const fem::Space& space, const ContactPairs& pairs,
                                              const std::vector<scene::Contact>& contacts);

/// Computes the contact pressure p from the nodal contact forces F_i = ∫ p φ_i of the candidates
/// (docs/method.md section 2).
///
/// For degree 1 the pressure at vertex v is F_v / ∫ φ_v, the mean of p weighted with the hat function φ_v.
/// For degree 2 this fails: on a triangle ∫ φ_i vanishes for vertices, whose forces are only rounding errors
/// and effects at the ends of contact. But the hat function of v is a combination of functions of degree 2:
/// φ¹_v = φ_v + ½ Σ φ_e over the edges e at v. Therefore F¹_v = F_v + ½ Σ F_e is exactly ∫ p φ¹_v, and the
/// pressure is F¹_v / ∫ φ¹_v, in the plane and in space. The integrals ∫ φ¹_v are positive, the sum of the
/// forces is unchanged, no force becomes negative, and a uniform pressure is reproduced. The error of the
/// weighted mean is O(h²) where p is smooth, like the error of stresses for displacements of degree 2.
/// Between vertices the pressure is linear. In axial symmetry the vertex on the axis has no candidate; the
/// pressure is constant up to the next vertex, whose hat function then includes the axis.
class Pressure {
public:
  /// Computes the areas that belong to the candidates of `contacts`. Collective. Throws UserError as
  /// ContactPairs does.
  Pressure(const fem::Space& space, const ContactPairs& pairs, const std::vector<scene::Contact>& contacts);

  /// Integral of each candidate's hat function over its obstacle's contact surface (m entries), in m in the
  /// plane and m² in space; 0 for candidates at midpoints of edges.
  [[nodiscard]] const std::vector<double>& area() const { return area_; }

  /// Pressures p of the candidates (m entries), N/m², positive in compression. `forces`: multipliers λ,
  /// `impulse` times the nodal contact forces; `impulse`: τ²/2 (Scheme::impulse()). A candidate at the
  /// midpoint of an edge gets the mean of the edge's ends. Ends with zero area() are left out; if both have
  /// zero area, the pressure is 0. It is also 0 at a vertex with zero area.
  [[nodiscard]] std::vector<double> operator()(std::span<const double> forces, double impulse) const;

  /// Sets the entries of nodes on the axis of a body of revolution that have no candidate in a field of this
  /// rank's nodes to the pressure of the next vertex. `pressures`: of the candidates. Not collective.
  void extend_to_axis(const std::vector<double>& pressures, std::vector<double>& field) const;

private:
  /// Edge of the contact surface: the candidates at its midpoint and at its ends; −1 for an end without
  /// candidate.
  struct Edge {
    int middle;
    std::array<int, 2> ends;
  };
  void add_edges(const fem::Space& space, const ContactPairs& pairs, const std::string& group, int obstacle);
  /// Sets the areas of obstacles to zero except at vertices of an edge whose midpoint is a candidate (others
  /// are clamped).
  void clear_areas_off_edges(const ContactPairs& pairs);
  /// Converts integrals with functions of degree 2, one for each candidate, to integrals with hat functions,
  /// in place.
  void gather_at_vertices(std::vector<double>& values) const;

  std::vector<Edge> edges_;
  std::vector<std::pair<int, int>>
      axis_; ///< owned nodes on the axis without candidate, and the next vertex's candidate
  std::vector<double> area_;
};

/// Sets the entries of the master nodes of contact between parts that this rank owns to the pressures there,
/// Σ_i C_ij F_i / ∫ φ_j. `pressures`: of the candidates, N/m². Not collective.
void extend_to_masters(const fem::Space& space, const ContactPairs& pairs,
                       const std::vector<double>& pressures, std::vector<double>& field);

/// Converts values of candidates (m entries) to values at the nodes that this rank owns: the largest value of
/// a node's candidates, and 0 at nodes without candidate or with negative values only. Not collective.
std::vector<double> at_nodes(const fem::Space& space, const ContactPairs& pairs,
                             const std::vector<double>& values);

/// Returns the tangential tractions of contact on the body at the candidates (m × dim), N/m², zero without
/// friction. `rho`: multipliers of all rows; `impulse`: as for Pressure.
[[nodiscard]] std::vector<double> tangential_tractions(const ContactPairs& pairs, const Pressure& pressure,
                                                       std::span<const double> rho, double impulse);

/// Sets `field` (in V) to the tangential traction of contact on the body at the candidates' nodes, N/m², and
/// its reaction at master nodes, as extend_to_masters() does; to zero elsewhere. `rho` and `impulse` as
/// above. Not collective.
void set_friction(const fem::Space& space, const ContactPairs& pairs, const Pressure& pressure,
                  std::span<const double> rho, double impulse, Vec field);

} // namespace signorini::contact
