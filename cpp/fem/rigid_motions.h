// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/operators.h"
#include <vector>

namespace signorini::fem {

/// Basis of the rigid motions, translations and infinitesimal rotations, that no clamp resists, of each
/// connected part of the mesh by itself. It is orthonormal in the product of the mass matrix.
class RigidMotions {
public:
  /// Computes the basis; it is empty if the mesh has more than 16 parts. Collective. `M` must outlive this
  /// object.
  RigidMotions(const Space& space, const DirichletDofs& clamped, Mat M);

  [[nodiscard]] std::size_t count() const { return basis_.size(); }
  [[nodiscard]] const std::vector<petsc::Vector>& basis() const { return basis_; }
  /// Coefficients (count) of the rigid part of x, the rigid motion nearest to x by mass. Collective.
  [[nodiscard]] std::vector<double> coefficients(Vec x) const { return products(weighed_, x); }
  /// Products of the basis with a functional; for a force, the rigid acceleration. Collective.
  [[nodiscard]] std::vector<double> products(Vec functional) const { return products(basis_, functional); }
  /// x −= the rigid motion of these coefficients.
  void subtract(const std::vector<double>& coefficients, Vec x) const;
  /// out ← x − the rigid motion of these coefficients.
  void without(const std::vector<double>& coefficients, Vec x, Vec out) const {
    petsc::check(VecCopy(x, out));
    subtract(coefficients, out);
  }
  /// f −= M times the rigid motion of these coefficients, for a functional f.
  void subtract_forces(const std::vector<double>& coefficients, Vec f) const;

private:
  static std::vector<double> products(const std::vector<petsc::Vector>& with, Vec x);

  std::vector<petsc::Vector> basis_, weighed_; ///< basis, and M times it
};

} // namespace signorini::fem
