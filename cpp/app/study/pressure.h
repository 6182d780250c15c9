#pragma once
#include "app/problem.h"
#include <array>
#include <vector>

namespace signorini::study {

/// Pressures at the vertices of the contact surface from the candidates' nodal forces F_i = ∫ p φ_i.
///
/// With degree 1 the pressure at vertex v is F_v / ∫ φ_v, the mean of p weighted with the hat function φ_v.
/// With degree 2 the integrals ∫ φ_i cannot be divided by: on a triangle they vanish for vertices, whose
/// forces are rounding and effects of the ends of contact. But hat functions are of degree 2 too, φ¹_v = φ_v
/// + ½ Σ φ_e over the edges e at v, so that their forces are known exactly: F¹_v = F_v + ½ Σ F_e. The
/// pressure is F¹_v / ∫ φ¹_v, in the plane and in space: the integrals are positive, forces add up to the
/// same, none becomes negative, and a uniform pressure is reproduced. The weighted mean is off by O(h²) where
/// p is smooth, which is the order of the stresses of displacements of degree 2.
class Pressure {
public:
  /// For a scene with contact. `problem` must outlive this object. Collective. Throws UserError.
  explicit Pressure(const Problem& problem);

  /// The integral of each candidate's hat function over its surface (m entries), m in the plane, m² in space;
  /// 0 for candidates in the middle of edges.
  [[nodiscard]] const std::vector<double>& area() const { return area_; }

  /// The pressures p (m entries) of forces λ / `impulse`, N/m²; 0 where there is no area.
  [[nodiscard]] std::vector<double> operator()(std::vector<double> lambda, double impulse) const;

private:
  /// The candidate in the middle of an edge, and those at its ends; −1 where there is none.
  struct Edge {
    int middle;
    std::array<int, 2> ends;
  };
  void add_edges(const Problem& problem, int obstacle);
  /// Converts integrals with functions of degree 2 to those with hat functions, in place.
  void gather_at_vertices(std::vector<double>& values) const;

  std::vector<Edge> edges_;
  std::vector<double> area_;
};

} // namespace signorini::study
