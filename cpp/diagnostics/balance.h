// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "trajectory/time_integrator.h"
#include <array>
#include <cmath>
#include <string>

namespace signorini::diagnostics {

struct BodyFigures;

/// Euclidean norm.
[[nodiscard]] inline double length(const std::array<double, 3>& x) { return std::hypot(x[0], x[1], x[2]); }

/// Energy and momentum balance of one step, from the exact discrete identities of docs/method.md section 2.
/// In 2D energies are J/m, forces N/m.
struct StepBalance {
  double kinetic_energy = 0;      ///< ½ v·Mv at the end of the step
  double elastic_energy = 0;      ///< ½ y·Ay at the end of the step
  double viscous_dissipation = 0; ///< τ w·Bw of the step, w = (y_k − y_{k−1})/τ
  double external_work = 0;   ///< f·(y_k − y_{k−1}) of the step, control and the motion of clamps included
  double load_work = 0;       ///< work of the scene's loads alone
  double contact_work = 0;    ///< F_k·(y_k − y_{k−1}), never positive where obstacles rest
  double energy_residual = 0; ///< residual of the energy identity
  std::array<double, 3> contact_force{}; ///< resultant on the body
  std::array<double, 3> momentum{};      ///< momentum at the end of the step, kg m/s
  std::array<double, 3>
      momentum_residual{}; ///< rate of momentum less loads, contact forces and the clamp's reaction
  double momentum_scale =
      0; ///< sum of the moduli of the terms of the momentum balance, for judging the residual
};

/// Computes the balances of a motion frame by frame, from frame 0 on; that of frame 0 has the initial
/// energies only.
class Balance {
public:
  /// Optional parts of a balance.
  struct Wanted {
    bool reactions = false;            ///< whether to compute the reactions of the clamps
    bool controlled = false;           ///< whether other forces act than the scene's loads
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
  /// Adds the terms of the state at the end of the step. Collective.
  void add_state(const trajectory::Frame& frame, Sums& sums);
  /// Adds the terms of the step. Returns the work of loads_alone_. Collective.
  double add_step(const trajectory::Frame& frame, Sums& sums);

  const step::Stepper& stepper_;
  bool reactions_;
  petsc::Vector Ay0_, Ay1_, Mv0_, Mv1_, Bw_, w_, load_, force_, defect_;
  std::optional<step::ForceAtStep> loads_alone_;
  double energy_ = 0; ///< energy of the last frame
};

/// Monitors the exact laws of the scheme (docs/method.md section 2) step by step. Each defect is relative to
/// the largest quantity of its kind in the run so far, or to the body's diameter. Contact forces are relative
/// to at least the force of an impact with the run's energy: its momentum over the time that a wave takes
/// across the body. At a touch there may be no force yet.
class Invariants {
public:
  struct Defect {
    const char* name;
    double worst = 0; ///< worst of the steps so far
    int step = 0;     ///< step of the worst
  };

  /// Collective. `stepper` must outlive this object.
  Invariants(const step::Stepper& stepper, const BodyFigures& body);

  /// Updates the defects by the frame that follows the last one, and its balance.
  void observe(const trajectory::Frame& frame, const StepBalance& balance);

  /// Energy law and momentum law; with contact also penetration, adhesion and complementarity.
  [[nodiscard]] std::span<const Defect> defects() const {
    return {defects_.data(), stepper_.pairs() ? defects_.size() : 2};
  }

  /// Describes the worst of the last frame's defects if it is above `tolerance`.
  [[nodiscard]] std::optional<std::string> violation(double tolerance) const;

  /// Momentum defect, and largest of the contact defects, of the last frame.
  [[nodiscard]] double momentum() const { return now_[1]; }
  [[nodiscard]] double complementarity() const;

  /// Largest energy of the run so far, J (in 2D J/m).
  [[nodiscard]] double largest_energy() const { return energy_; }

private:
  const step::Stepper& stepper_;
  double stiffness_ = 0;   ///< largest diagonal entry of A, as its norm
  double mass_, crossing_; ///< mass of the body, kg (in 2D kg/m); crossing time of a wave, s
  double energy_ = 0, forces_ = 0, contact_force_ = 0;
  std::array<Defect, 5> defects_{{{"energy law, residual beyond rounding / largest energy"},
                                  {"momentum law, residual / largest forces"},
                                  {"penetration / diameter"},
                                  {"adhesion / force scale"},
                                  {"force x gap / (force scale x diameter)"}}};
  std::array<double, 5> now_{};
};

} // namespace signorini::diagnostics
