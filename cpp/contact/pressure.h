// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"
#include <array>
#include <vector>

namespace signorini::contact {

/// Pressures of the contact surface from the candidates' nodal forces F_i = ∫ p φ_i (docs/method.md section
/// 2).
///
/// The pressure at vertex v for degree 1 is F_v / ∫ φ_v, the mean of p weighted with the hat function φ_v.
/// For degree 2 the integrals ∫ φ_i are no divisors: on a triangle they vanish for vertices, whose forces are
/// rounding and effects of the ends of contact. But hat functions are of degree 2 too, φ¹_v = φ_v + ½ Σ φ_e
/// over the edges e at v. Their forces are therefore known exactly: F¹_v = F_v + ½ Σ F_e. The pressure is
/// F¹_v / ∫ φ¹_v, in the plane and in space. The integrals are positive, the sum of the forces is unchanged,
/// none becomes negative, and a uniform pressure is reproduced. The weighted mean has an error of O(h²) where
/// p is smooth, the order of the stresses of displacements of degree 2. Between vertices the pressure is
/// linear.
class Pressure {
public:
  /// Computes the areas of the pairs of `contacts`. Collective. Throws UserError as ContactPairs does.
  Pressure(const fem::Space& space, const ContactPairs& pairs, const std::vector<scene::Contact>& contacts);

  /// The integral of each candidate's hat function over the surface of its obstacle's group (m entries), m in
  /// the plane, m² in space; 0 for candidates in the middle of edges.
  [[nodiscard]] const std::vector<double>& area() const { return area_; }

  /// Pressures p (m entries) from `forces` λ divided by `impulse`, N/m², positive in compression. Candidates
  /// in the middle of an edge have the mean of the edge's ends. 0 where no candidate has an area.
  [[nodiscard]] std::vector<double> operator()(std::span<const double> forces, double impulse) const;

private:
  /// The candidate in the middle of an edge, and those at its ends; −1 where there is none.
  struct Edge {
    int middle;
    std::array<int, 2> ends;
  };
  void add_edges(const fem::Space& space, const ContactPairs& pairs, const std::string& group, int obstacle);
  /// Keeps the areas of vertices alone, and none at a vertex whose edges are all clamped.
  void keep_areas_of_edges();
  /// Converts integrals with functions of degree 2 to those with hat functions, in place.
  void gather_at_vertices(std::vector<double>& values) const;

  std::vector<Edge> edges_;
  std::vector<double> area_;
};

/// Values of the candidates (m) as a field at the nodes that this rank owns: the largest of a node's
/// candidates, 0 at nodes without one. Not collective.
std::vector<double> at_nodes(const fem::Space& space, const ContactPairs& pairs,
                             const std::vector<double>& values);

} // namespace signorini::contact
