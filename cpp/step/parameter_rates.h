// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/parameters.h"
#include "step/step.h"
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace signorini::step {

struct SplitStiffness;

/// Data of a completed step for its derivatives by parameters.
struct StepMade {
  TimeStep step;
  const State &from, &to;
  const contact::ContactLinearisation& contact;
};

/// Derivatives of the step equations by the unknowns θ_j of a scene, at fixed states (docs/method.md section
/// 9). The sensitivities δ, per unit of θ_j, satisfy
///     D δy_k + N δλ_k = R δy_{k−1} + … + s_kj,   ν·δy_k = c_kj on A_k,   δy_0, δv_0
/// and, for the projected predictor of contact-stabilized steps,
///     M δz + N δζ = M δx + r_kj,   ν·δz = e_kj on Z_k.
/// This class computes the sources s_kj, c_kj, r_kj, e_kj and the initial δy_0, δv_0. All members are
/// collective.
class ParameterRates {
public:
  /// Prepares the derivatives by all unknowns of `scene`, the scene as read from its file. `values`: values
  /// of the unknowns in the scene from which `stepper` was created. `stepper` must outlive this object.
  /// Throws UserError.
  ParameterRates(const Stepper& stepper, const scene::Scene& scene, std::span<const double> values);
  ~ParameterRates();

  /// Number of unknowns.
  [[nodiscard]] std::size_t count() const { return rates_.size(); }
  /// Sets the step to which the other members refer; the vectors in `made` must not change until the next
  /// set().
  void set(const StepMade& made);

  /// Adds s_kj, the derivative of the step's right-hand side by unknown j, to `sum`.
  void add_step_source(std::size_t j, Vec sum);
  /// Adds the derivative of q_k by unknown j, at fixed y_k, y_{k−1} and q_{k−1}, to the parts q of `sum`.
  void add_branch_source(std::size_t j, const State& sum);
  /// Returns p·s_kj, the product of p with the derivative of the step's right-hand side by unknown j, and the
  /// product of the derivative of q_k with its dual, given by `z` as in AdjointState.
  [[nodiscard]] double pairing(std::size_t j, Vec p, const petsc::Series& z);
  /// Sets `c` to c_kj (rows, m), the value of ν·δy_k that unknown j prescribes on the active set. Returns
  /// false and leaves `c` unchanged if c_kj is zero.
  bool constraint(std::size_t j, std::span<double> c);

  /// Sets `c` (rows) to the derivative by unknown j of the right-hand sides of the linearised contact laws.
  /// Returns false and leaves `c` unchanged if it is zero.
  bool law(std::size_t j, std::span<double> c) const;

  /// Sets `r` to r_kj and `e` (one entry for each row, m) to e_kj, the right-hand sides by which unknown j
  /// changes the projection of the predictor.
  /// Returns false and leaves both unchanged if Z_k is empty or both are zero.
  bool predictor(std::size_t j, Vec r, std::span<double> e);

  /// Returns δH, the derivative of the constraint rows by unknown j; null if it is zero.
  [[nodiscard]] const contact::ConstraintRows* rows(std::size_t j) const;

  /// Returns δy_0, the derivative of the initial displacement by unknown j; null if it is zero.
  [[nodiscard]] Vec displacement(std::size_t j) const;
  /// Returns δv_0, the derivative of the initial velocity by unknown j; null if it is zero.
  [[nodiscard]] Vec velocity(std::size_t j) const;

private:
  struct Rate;
  /// Returns whether the candidates' normals depend on any unknown.
  [[nodiscard]] bool turn() const;
  void add_material(const scene::Scene& scene, const scene::Unknown& unknown, Rate& rate);
  void add_relaxing(const scene::Scene& scene, const scene::Unknown& unknown, Rate& rate);
  void add_foundation(const scene::Scene& scene, const scene::Unknown& unknown, Rate& rate) const;
  void add_obstacle(const scene::Scene& scene, std::span<const double> values, std::size_t j,
                    Rate& rate) const;
  void add_rigid_body(const scene::Scene& scene, const scene::Unknown& unknown, Rate& rate) const;
  void add_initial(const scene::Scene& scene, const scene::Unknown& unknown, Rate& rate) const;
  void add_load(const scene::Scene& scene, std::span<const double> values, const scene::Unknown& unknown,
                Rate& rate) const;
  template <class Add>
  void for_each_product(const Rate& rate, const Scheme& scheme, Add&& add);
  /// Sets rate.load to the weight of rate.M, the derivative of the mass matrix, and of the obstacles
  /// `contacts`, if the scene has gravity.
  void add_gravity(const scene::Scene& scene, Rate& rate,
                   const std::vector<scene::Contact>& contacts = {}) const;
  /// Returns the derivative of massless contact's mass matrix by unknown j, a parameter of an obstacle, by
  /// central differences.
  [[nodiscard]] petsc::Matrix redistributed_mass_rate(const scene::Scene& scene,
                                                      std::span<const double> values, std::size_t j) const;

  const Stepper& stepper_;
  std::vector<std::unique_ptr<Rate>> rates_;
  std::map<std::size_t, std::shared_ptr<const SplitStiffness>> stiffness_; ///< by the material's number
  std::optional<StepMade> made_;
  /// y_k + y_{k−1}, y_k − y_{k−1}, τ_k w − (y_k − y_{k−1}) with the step's starting velocity w, and the jump
  /// z − x.
  petsc::Vector sum_, difference_, inertia_, jump_;
  bool jumps_ = false;                ///< whether Z_k has candidates
  std::vector<double> lambda_, zeta_; ///< λ_k and ζ_k (rows); set only if turn()
  petsc::Vector work_, combination_;  ///< combination_: null without branches
  std::vector<double> components_;
  std::optional<MovingClamps::Evaluation> motion_;
};

} // namespace signorini::step
