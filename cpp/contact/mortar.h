// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/surface.h"
#include <array>
#include <string>
#include <utility>
#include <vector>

namespace signorini::contact {

/// Constraint of a slave node against a master surface by dual mortar (docs/method.md section 2): the jump
/// Σ_j B_ij y_j − Σ_j C_ij y_j of displacements, weighted with the dual function of the node, along the
/// direction ν_i. For degree 1 B is the identity; for degree 2 rows have midpoints and neighbours too.
struct MortarRow {
  int vertex;                                 ///< number of the slave node in its surface
  std::array<double, 3> nu;                   ///< ν_i, unit vector out of the slave surface
  double area;                                ///< W_i = ∫ φ_i over the covered part, m or m²
  double gap;                                 ///< ψ_i of the undeformed bodies, m
  std::vector<std::pair<int, double>> master; ///< nodes of the master surface with C_ij; their sum is 1
  double own = 1; ///< B_ii, the part of the slave node itself in the jump; 1 for degree 1
  std::vector<std::pair<int, double>> slave{}; ///< other nodes of the slave facets with B_ij
};

/// Computes the rows of all slave nodes that face the master surface, ordered by their numbers.
///
/// For each slave node i both surfaces are projected along ν_i, the mean of the normal of its facets and,
/// with a minus, of that of the master facets opposite them: where two equal bodies touch, it is normal to
/// the plane between them. The dual function ψ_i is the combination of the facet's hat functions with ∫ ψ_i
/// φ_k = δ_ik ∫ φ_k over the part of each facet that the master surface covers (Wohlmuth 2000; Popp,
/// Gitterle, Gee and Wall 2010); it is integrated exactly over the intersections of slave and master facets.
/// For degree 2 hat functions and their duals are the same, and slave nodes are vertices.
/// Each row reproduces translations, and its gap vector Σ_j C_ij x_j − x_i is parallel to ν_i, so that normal
/// forces conserve linear and angular momentum.
///
/// `dim`: of the bodies; `axisymmetric`: whether they are bodies of revolution, whose integrals have the
/// weight 2π r. `key`: of the contact in messages. Throws UserError if several parts of the master surface
/// lie behind each other as seen from a slave node.
[[nodiscard]] std::vector<MortarRow> mortar_rows(const fem::SurfaceMesh& slave,
                                                 const fem::SurfaceMesh& master, int dim, bool axisymmetric,
                                                 const std::string& key);

/// Integrals of the hat functions of a surface's vertices over all of their facets, m or m². `dim`,
/// `axisymmetric`: as in mortar_rows().
[[nodiscard]] std::vector<double> hat_areas(const fem::SurfaceMesh& surface, int dim, bool axisymmetric);

/// Mean length (in space: square root of the mean area) of the facets of a surface, m.
[[nodiscard]] double facet_size(const fem::SurfaceMesh& surface, int dim);

} // namespace signorini::contact
