// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/parameters.h"
#include "step/step.h"
#include <memory>
#include <optional>
#include <vector>

namespace signorini::step {

/// Data of a step that its derivatives by parameters need.
struct StepMade {
  TimeStep step;
  const State &from, &to;
  const contact::ContactLinearisation& contact;
};

/// Derivatives of the equations of steps by the unknowns of a scene, for fixed states (docs/method.md
/// section 9): per unit of the unknown j
///     D δy_k + N δλ_k = R δy_{k−1} + … + s_kj,   ν·δy_k = c_kj on A_k,   δy_0, δv_0
/// and, in contact-stabilized stepping, for the projected predictor
///     M δz + N δζ = M δx + r_kj,   ν·δz = e_kj on Z_k.
/// All members collective.
class ParameterRates {
public:
  /// `scene`: as read; `values`: those of its unknowns for which `stepper` was made. `stepper` must outlive
  /// this object. Throws UserError.
  ParameterRates(const Stepper& stepper, const scene::Scene& scene, std::span<const double> values);
  ~ParameterRates();

  [[nodiscard]] std::size_t count() const { return rates_.size(); }
  /// Sets the step that the other members refer to; its vectors must not change until the next set().
  void set(const StepMade& made);

  /// sum += s_kj.
  void add_source(std::size_t j, Vec sum);
  /// p·s_kj.
  [[nodiscard]] double pairing(std::size_t j, Vec p);
  /// Sets c_kj (m); false if it is zero, then c is left as it was.
  bool constraint(std::size_t j, std::span<double> c);

  /// Sets r_kj, and e_kj (m); false where Z_k is empty or both are zero.
  bool predictor(std::size_t j, Vec r, std::span<double> e);

  /// δH; null where zero.
  [[nodiscard]] const contact::ConstraintRows* rows(std::size_t j) const;

  /// δy_0 and δv_0; null where zero.
  [[nodiscard]] Vec displacement(std::size_t j) const;
  [[nodiscard]] Vec velocity(std::size_t j) const;

private:
  struct Rate;
  /// Whether normals change with any unknown.
  [[nodiscard]] bool turn() const;
  void add_material(const scene::Scene& scene, const scene::Unknown& unknown, Rate& rate) const;
  void add_obstacle(const scene::Scene& scene, std::span<const double> values, std::size_t j,
                    Rate& rate) const;
  void add_initial(const scene::Scene& scene, const scene::Unknown& unknown, Rate& rate) const;
  void add_load(const scene::Scene& scene, const scene::Unknown& unknown, Rate& rate) const;
  template <class Add>
  void for_each_product(const Rate& rate, const Scheme& scheme, Add&& add);
  /// Adds the weight of rate.M as a load.
  void add_gravity(const scene::Scene& scene, Rate& rate) const;
  /// ∂M of massless contact by an obstacle's parameter.
  [[nodiscard]] petsc::Matrix redistributed_mass_rate(const scene::Scene& scene,
                                                      std::span<const double> values, std::size_t j) const;

  const Stepper& stepper_;
  std::vector<std::unique_ptr<Rate>> rates_;
  std::optional<StepMade> made_;
  petsc::Vector sum_, difference_, inertia_, jump_; ///< y + y⁻, y − y⁻, τ momentum − (y − y⁻), z − x
  bool jumps_ = false;                              ///< whether Z_k is not empty
  std::vector<double> lambda_, zeta_;               ///< λ_k, ζ_k (m), where normals turn
  petsc::Vector work_;
  std::vector<double> components_;
  std::optional<MovingClamps::At> motion_;
};

} // namespace signorini::step
