#pragma once
#include "problem.h"
#include <array>
#include <vector>

namespace signorini::study {

/// Pressures at the vertices of the contact surface from the candidates' nodal forces F_i = ∫ p φ_i.
///
/// With degree 1 the pressure at vertex v is F_v / ∫ φ_v, the mean of p that the hat φ_v sees. With degree 2
/// the shares ∫ φ_i cannot be divided by: of a triangle, vertices have none and their forces are what
/// rounding and the ends of contact leave. But hats are functions of degree 2 too, φ¹_v = φ_v + ½ Σ φ_e over
/// the edges e at v, and so the forces that belong to them are known exactly: F¹_v = F_v + ½ Σ F_e. The
/// pressure is F¹_v / ∫ φ¹_v, in the plane and in space: shares are positive, forces add up to the same, none
/// becomes negative, and a uniform pressure comes out as it is. The mean over a hat is off by O(h²) where p
/// is smooth, which is the order of the stresses of displacements of degree 2.
class Pressure {
public:
  /// For a scene with contact. `problem` must outlive this object. Collective. Throws UserError.
  explicit Pressure(const Problem& problem);

  /// What of its surface each candidate stands for (m), in the plane m, in space m²; 0 for one at an edge.
  [[nodiscard]] const std::vector<double>& area() const { return area_; }

  /// The pressures p (m) of forces λ / `impulse`, N/m²; 0 where there is no area.
  [[nodiscard]] std::vector<double> operator()(std::vector<double> lambda, double impulse) const;

private:
  /// The candidate at an edge's middle, and those at its ends; −1 where there is none.
  struct Edge {
    int middle;
    std::array<int, 2> ends;
  };
  void add_edges(const Problem& problem, int obstacle);
  /// Sums of hats from those of functions of degree 2.
  void gather_at_vertices(std::vector<double>& values) const;

  std::vector<Edge> edges_;
  std::vector<double> area_;
};

} // namespace signorini::study
