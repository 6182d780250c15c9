// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <optional>
#include <string>

namespace signorini::fem {

/// A quadrature rule over the body.
struct Quadrature {
  std::vector<double> points;  ///< (n × 3), m
  std::vector<double> weights; ///< (n), m^dim
};

/// The rule of order 2 on every cell of a mesh; all points on every rank, sorted by coordinates. Collective.
Quadrature quadrature(const mesh::Mesh& mesh);

/// Evaluates functions of V at given points, the same for any number of ranks and any mesh of the body. At a
/// point just outside of this mesh, such as beyond a chord of a curved boundary, it evaluates the polynomial
/// of the nearest cell.
class Sampler {
public:
  /// Locates `points` (n × 3), m, the same on every rank. `on`: physical group to evaluate on: a part of the
  /// body, in its nearest cell, or a surface, at its nearest point. `cellwise`: evaluates functions that are
  /// constant on each cell (owned cells × dim) in place of V. Throws UserError naming `key` if there is no
  /// such group. Collective.
  Sampler(const Space& space, const std::vector<double>& points,
          const std::optional<std::string>& on = std::nullopt, const std::string& key = {},
          bool cellwise = false);

  /// Distances of the points from this mesh (n), m, zero inside.
  [[nodiscard]] const std::vector<double>& distances() const { return distances_; }

  /// Functional that evaluates one component of functions of V at a point, by its number. Collective.
  [[nodiscard]] petsc::Vector functional(std::size_t point, int component) const;

  /// Values of y at the points (n × dim), on every rank. Collective.
  [[nodiscard]] std::vector<double> operator()(Vec y) const;

private:
  int dim_;
  MPI_Comm comm_;
  std::vector<std::size_t> mine_; ///< numbers of the points that this rank evaluates
  std::size_t count_;
  std::vector<double> distances_;
  petsc::Matrix at_points_; ///< evaluation at points; one component for all (MAIJ)
  petsc::Vector values_;
};

} // namespace signorini::fem
