// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/parameters.h"
#include "step/step.h"
#include <memory>
#include <vector>

namespace signorini::step {

/// Stiffness of one material that relaxes, at the instant of loading: against shear K_s and against changes
/// of volume K_b, as upper halves in blocks.
struct SplitStiffness {
  petsc::Matrix shear, bulk;

  /// Assembles K_s and K_b of the material with the number `material`. Collective.
  SplitStiffness(const fem::Space& space, const std::vector<scene::Material>& materials,
                 std::size_t material);
};

/// Factors of K_s and K_b in a sum of both.
struct SplitFactors {
  double shear = 0, bulk = 0;
};

/// Derivative of the step equations by an unknown that changes the stiffness of a material that relaxes
/// (docs/method.md section 9). It consists of K_s and K_b alone.
class RelaxingRate {
public:
  /// Prepares the derivative by `unknown` at the values in `scene`. `unknown.of` is Young's modulus,
  /// Poisson's ratio, a branch's g, k or time, or the β of Rayleigh damping. `stiffness`: K_s and K_b of its
  /// material.
  RelaxingRate(const fem::Relaxation& relaxation, const scene::Scene& scene, const scene::Unknown& unknown,
               std::shared_ptr<const SplitStiffness> stiffness);

  /// Vectors of a step: y_k + y_{k−1}, y_k − y_{k−1}, and the state at t_{k−1}.
  struct Step {
    Scheme scheme;
    Vec sum, difference;
    const State& from;
  };

  /// Calls add(matrix, x) for each product matrix · x in the derivative of the step's right-hand side.
  /// `work`: scratch, which x may be.
  template <class Add>
  void for_each_product(const Step& step, Vec work, Add&& add) const {
    for (double SplitFactors::* part : {&SplitFactors::shear, &SplitFactors::bulk})
      if (combine(step, part, work))
        add(part == &SplitFactors::shear ? Mat(stiffness_->shear) : Mat(stiffness_->bulk), work);
  }

  /// Adds the derivatives of q_j,k at fixed y_k, y_{k−1} and q_j,k−1 to the parts q_j of `sum`.
  void add_branches(const Step& step, const State& sum) const;
  /// Returns the sum of the products of these derivatives with their duals A_j z_j. `change`, `work`:
  /// scratch. Collective.
  [[nodiscard]] double branch_pairing(const Step& step, const petsc::Series& z, Vec change, Vec work) const;

private:
  /// Branch of the material, its fractions and time, and their derivatives by the unknown.
  struct OfBranch {
    std::size_t number; ///< index of q_j
    SplitFactors value, rate;
    double time;
    bool time_unknown;
  };
  /// Sets `work` to the vector by which K_s or K_b is multiplied in the derivative of the right-hand side.
  /// Returns false if it is zero. Collective.
  bool combine(const Step& step, double SplitFactors::* part, Vec work) const;

  std::shared_ptr<const SplitStiffness> stiffness_;
  SplitFactors A_, B_; ///< derivatives of A and of B
  std::vector<OfBranch> branches_;
};

} // namespace signorini::step
