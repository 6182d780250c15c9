// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/operators.h"
#include <vector>

namespace signorini::fem {

/// Basis of the rigid motions (translations and infinitesimal rotations) that no clamp resists, separately
/// for each connected part of the mesh. The basis is orthonormal in the inner product of the mass matrix.
class RigidMotions {
public:
  /// Computes the basis. It is empty if the mesh has more than 16 connected parts. Collective.
  RigidMotions(const Space& space, const DirichletDofs& clamped, Mat M);

  [[nodiscard]] std::size_t count() const { return basis_.size(); }
  [[nodiscard]] const std::vector<petsc::Vector>& basis() const { return basis_; }
  /// Returns the count() coefficients of the rigid part of x, which is the rigid motion nearest to x in the
  /// norm of the mass matrix. Collective.
  [[nodiscard]] std::vector<double> coefficients(Vec x) const { return products(weighed_, x); }
  /// Returns the count() values of a functional on the basis. For a force, these are the coefficients of the
  /// rigid acceleration. Collective.
  [[nodiscard]] std::vector<double> products(Vec functional) const { return products(basis_, functional); }
  /// x −= Σ coefficients_i basis_i.
  void subtract(const std::vector<double>& coefficients, Vec x) const;
  /// out ← x − Σ coefficients_i basis_i.
  void without(const std::vector<double>& coefficients, Vec x, Vec out) const {
    petsc::check(VecCopy(x, out));
    subtract(coefficients, out);
  }
  /// f −= M Σ coefficients_i basis_i, for a functional f such as a force.
  void subtract_forces(const std::vector<double>& coefficients, Vec f) const;

private:
  static std::vector<double> products(const std::vector<petsc::Vector>& with, Vec x);

  std::vector<petsc::Vector> basis_, weighed_; ///< basis; M times basis
};

} // namespace signorini::fem
