// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "fem/space.h"
#include "scene/body.h"
#include <cstddef>
#include <span>
#include <vector>

namespace signorini::fem {

/// Branches of the materials that relax (docs/method.md section 1): branch j has the form A_j = g_j K_s + k_j
/// K_b and the internal displacement q_j, q̇_j = v − q_j/t_j. K_s and K_b are the stiffness of a material's
/// cells against shear and against changes of volume, at the instant of loading.
class Relaxation {
public:
  /// One branch; `material` is its index in the scene.
  struct Branch {
    std::size_t material;
    double g, k; ///< fractions of the instantaneous shear and bulk modulus
    double time; ///< relaxation time t_j, s
  };

  /// Stiffness of one material, as upper halves (SBAIJ). If g = k in all its branches, `shear` is K_s + K_b
  /// and `bulk` is null; otherwise a matrix is null if no branch contains it.
  struct Stiffness {
    std::size_t first, count; ///< its branches, by their indices in branches()
    petsc::Matrix shear, bulk;
  };

  /// Assembles the stiffness of the materials that relax. Collective. Throws UserError unless every cell
  /// belongs to exactly one material.
  Relaxation(const Space& space, const std::vector<scene::Material>& materials);

  /// Returns the branches of all materials, in the order of the scene; there is one q_j for each.
  [[nodiscard]] std::span<const Branch> branches() const { return branches_; }
  /// Returns the stiffness of each material that relaxes.
  [[nodiscard]] std::span<const Stiffness> stiffnesses() const { return stiffnesses_; }

  /// Linear combinations x_j = weights_j vectors_j + common_weights_j common, one for each branch; vectors of
  /// V. `common` is null if no weight refers to it.
  struct Combinations {
    std::span<const double> weights;
    std::span<const petsc::Vector> vectors;
    std::span<const double> common_weights{};
    Vec common = nullptr;
  };
  /// Adds Σ_j A_j x_j to `sum`, by at most two products for each material. `work`: scratch, a vector of V.
  /// Collective.
  void add(const Combinations& x, Vec sum, Vec work) const;

  /// Returns the memory of the matrices on all ranks, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  std::vector<Branch> branches_;
  std::vector<Stiffness> stiffnesses_;
};

} // namespace signorini::fem
