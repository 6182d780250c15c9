// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/operators.h"
#include <vector>

namespace signorini::fem {

/// The rigid motions, translations and infinitesimal rotations, that no clamp resists, of each connected part
/// of the mesh by itself: a basis that is orthonormal in the product of the mass matrix.
class RigidMotions {
public:
  /// Of no part if the mesh has more than 16. Collective. `M` must outlive this object.
  RigidMotions(const Space& space, const DirichletDofs& clamped, Mat M);

  [[nodiscard]] std::size_t count() const { return basis_.size(); }
  [[nodiscard]] const std::vector<petsc::Vector>& basis() const { return basis_; }
  /// The coefficients of the rigid part of x, the nearest to it by mass (count). Collective.
  [[nodiscard]] std::vector<double> coefficients(Vec x) const { return products(weighed_, x); }
  /// The products of the basis with a functional: of a force, the rigid acceleration. Collective.
  [[nodiscard]] std::vector<double> products(Vec functional) const { return products(basis_, functional); }
  /// x −= the rigid motion of these coefficients.
  void subtract(const std::vector<double>& coefficients, Vec x) const;
  /// out ← x less that.
  void without(const std::vector<double>& coefficients, Vec x, Vec out) const {
    petsc::check(VecCopy(x, out));
    subtract(coefficients, out);
  }
  /// The same of functionals: f −= M times the rigid motion of these coefficients.
  void subtract_forces(const std::vector<double>& coefficients, Vec f) const;

private:
  static std::vector<double> products(const std::vector<petsc::Vector>& with, Vec x);

  std::vector<petsc::Vector> basis_, weighed_; ///< and M times it
};

} // namespace signorini::fem
