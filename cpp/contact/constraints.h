#pragma once
#include "fem/operators.h"
#include <span>

namespace signorini::contact {

/// The linearised nonpenetration constraints g_i(y) = ψ_i − ν_i·y_i ≥ 0 of the m contact candidates
/// (method.md section 2): the nodes of the contact boundary that no clamp holds. Candidates are numbered by
/// their coordinates, so that the numbering does not depend on the number of ranks; all arrays over
/// candidates are the same on every rank.
class Constraints {
public:
  /// Collective. Throws UserError if the group is missing or holds only clamped nodes.
  Constraints(const fem::Space& space, const fem::Clamped& clamped, const scene::Contact& contact);

  /// m, on all ranks.
  [[nodiscard]] int count() const { return static_cast<int>(psi_.size()); }
  /// Coordinates (m × 3), m.
  [[nodiscard]] const std::vector<double>& points() const { return points_; }
  /// ν_i (m × dim), unit vectors from the body to the obstacle.
  [[nodiscard]] const std::vector<double>& normals() const { return normals_; }
  /// ψ_i (m), gaps of the undeformed body, m.
  [[nodiscard]] const std::vector<double>& psi() const { return psi_; }
  /// First global dof of each candidate's node (m).
  [[nodiscard]] const std::vector<PetscInt>& first_dofs() const { return first_dofs_; }
  /// A gap is closed, and a penetration rounding, below this length: 1e-10 of the body's diameter, m.
  [[nodiscard]] double gap_tolerance() const { return gap_tolerance_; }
  [[nodiscard]] int dim() const { return dim_; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

  /// Nᵀx: the ν-components of a vector at the candidates (m). Collective.
  void normal_components(Vec x, std::span<double> out) const;

  /// g(y) (m), m. Collective.
  void gap(Vec y, std::span<double> out) const;

  /// x += scale · Nλ.
  void add_normal(double scale, std::span<const double> lambda, Vec x) const;

  /// Changes x along ν at the candidates of a set so that x·ν = value (m) there.
  void set_normal(std::span<const int> set, std::span<const double> value, Vec x) const;

  /// Throws UserError naming the deepest candidate if `y` starts inside the obstacle. Collective.
  void require_outside(Vec y) const;

private:
  int dim_;
  double gap_tolerance_;
  std::vector<double> points_, normals_, psi_;
  std::vector<PetscInt> first_dofs_;
  std::vector<int> local_; ///< first local dof of each candidate's node, −1 on ranks that do not own it (m)
  MPI_Comm comm_;
};

} // namespace signorini::contact
