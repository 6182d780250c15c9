#pragma once
#include "fem/space.h"

namespace signorini::fem {

/// Points of a body and the volumes that they stand for: a quadrature.
struct Quadrature {
  std::vector<double> points;  ///< (n × 3), m
  std::vector<double> weights; ///< (n), m^dim
};

/// The rule of order 2 on every cell of a mesh, its points on all ranks alike, by place. Collective.
Quadrature quadrature(const mesh::Mesh& mesh);

/// Values of functions of V at given points, the same points on any number of ranks and any mesh of the body. A point just
/// outside of this mesh, as beyond a chord of a curved boundary, gets the polynomial of the nearest cell.
class Sampler {
public:
  /// `points` (n × 3), the same on every rank. Collective.
  Sampler(const Space& space, const std::vector<double>& points);

  /// (n × dim), on every rank. Collective.
  [[nodiscard]] std::vector<double> operator()(Vec y) const;

private:
  int dim_;
  MPI_Comm comm_;
  std::vector<std::size_t> mine_; ///< numbers of the points that this rank evaluates
  std::size_t count_;
  petsc::Matrix at_points_; ///< one component for all (MAIJ)
  petsc::Vector values_;
};

} // namespace signorini::fem
