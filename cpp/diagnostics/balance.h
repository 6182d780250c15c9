// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "trajectory/integrate.h"
#include <array>

namespace signorini::diagnostics {

/// Energy and momentum balance of one step, from the exact discrete identities of docs/method.md section 2.
/// In 2D energies are J/m, forces N/m.
struct StepBalance {
  double kinetic_energy = 0;      ///< ½ v·Mv at the end of the step
  double elastic_energy = 0;      ///< ½ y·Ay at the end of the step
  double viscous_dissipation = 0; ///< τ w·Bw of the step, w = (y_k − y_{k−1})/τ
  double external_work = 0;   ///< f·(y_k − y_{k−1}) of the step, control and the motion of clamps included
  double load_work = 0;       ///< the same of the scene's loads alone
  double contact_work = 0;    ///< F_k·(y_k − y_{k−1}), never positive where obstacles rest
  double energy_residual = 0; ///< of the energy identity
  std::array<double, 3> contact_force{}; ///< resultant on the body
  std::array<double, 3> momentum{};      ///< at the end of the step, kg m/s
  std::array<double, 3>
      momentum_residual{}; ///< rate of momentum less loads, contact forces and the clamp's reaction
  double momentum_scale =
      0; ///< sum of the moduli of the terms of the momentum balance, for judging the residual
};

/// Computes the balances of a motion frame by frame, from frame 0 on, whose balance holds the initial
/// energies only.
class Balance {
public:
  /// What of a motion is wanted besides.
  struct Wanted {
    bool reactions = false;            ///< of the clamps
    bool controlled = false;           ///< other forces act than the scene's loads
    const step::Load* loads = nullptr; ///< the scene's loads in this case, null without any
  };

  /// Collective. The references must outlive this object.
  explicit Balance(const step::Stepper& stepper, Wanted wanted);
  explicit Balance(const step::Stepper& stepper) : Balance(stepper, Wanted{}) {}

  /// Balance of the frame that follows the last one. Allocates nothing. Collective.
  StepBalance operator()(const trajectory::Frame& frame);

  /// Forces of the clamps on the body in the last frame's step, on the clamped dofs; other entries have no
  /// meaning. Null unless wanted, zero in frame 0.
  [[nodiscard]] Vec reactions() const { return reactions_ ? Vec(defect_) : nullptr; }

private:
  struct Sums;
  /// What the state at the end of the step adds. Collective.
  void add_state(const trajectory::Frame& frame, Sums& sums);
  /// What the step adds. Returns the work of loads_alone_. Collective.
  double add_step(const trajectory::Frame& frame, Sums& sums);

  const step::Stepper& stepper_;
  bool reactions_;
  petsc::Vector Ay0_, Ay1_, Mv0_, Mv1_, Bw_, w_, load_, force_, defect_;
  std::optional<step::ForceAtStep> loads_alone_;
  double energy_ = 0; ///< of the last frame
};

} // namespace signorini::diagnostics
