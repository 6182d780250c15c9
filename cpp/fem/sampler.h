// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <optional>
#include <string>

namespace signorini::fem {

/// A quadrature rule over the body.
struct Quadrature {
  std::vector<double> points;  ///< (n × 3), m
  std::vector<double> weights; ///< (n), m^dim; m³ in axial symmetry
};

/// Points and weights of a quadrature rule on every cell of the mesh, over the whole body in axial symmetry;
/// exact for squares of linear functions. The result contains the points of all ranks, sorted by coordinates,
/// and is the same on every rank. Collective.
Quadrature quadrature(const mesh::Mesh& mesh);

/// Evaluates functions of V at fixed points, which may come from another mesh of the same body. The result
/// does not depend on the number of ranks. At a point outside of this mesh, for example beyond a chord of a
/// curved boundary, it evaluates the polynomial of the nearest cell.
class Sampler {
public:
  /// Locates `points` (n × 3), m, the same on every rank. `on`: physical group to evaluate on, by default the
  /// whole body. If it is a part of the body, the nearest cell of this part is used; if it is a surface, the
  /// nearest point of the surface. `cellwise`: evaluates cellwise constant functions (owned cells × dim)
  /// instead of functions of V. Throws UserError naming `key` if the group does not exist. Collective.
  Sampler(const Space& space, const std::vector<double>& points,
          const std::optional<std::string>& on = std::nullopt, const std::string& key = {},
          bool cellwise = false);

  /// Distances (n) of the points from the mesh or, if `on` was given, from this group, m. The distance of a
  /// point inside is zero.
  [[nodiscard]] const std::vector<double>& distances() const { return distances_; }

  /// Functional that maps a function of V to its component number `component` at the point number `point`.
  /// Collective.
  [[nodiscard]] petsc::Vector functional(std::size_t point, int component) const;

  /// Values of y at all points (n × dim), the same on every rank. Collective.
  [[nodiscard]] std::vector<double> operator()(Vec y) const;

private:
  int dim_;
  MPI_Comm comm_;
  std::vector<std::size_t> mine_; ///< numbers of the points that this rank evaluates
  std::size_t count_;
  std::vector<double> distances_;
  petsc::Matrix at_points_; ///< evaluation at the points of this rank; one component for all (MAIJ)
  petsc::Vector values_;
};

} // namespace signorini::fem
