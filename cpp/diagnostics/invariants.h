// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "diagnostics/balance.h"
#include "diagnostics/body_figures.h"
#include <array>
#include <string>

namespace signorini::diagnostics {

/// Monitors what the scheme conserves exactly (docs/method.md section 2), step by step: each defect is
/// relative to the largest quantity of its kind in the run so far, or to the body's diameter. Contact forces
/// are relative to at least the force with which a body of the run's energy meets an obstacle: what momentum
/// that is, within the time that a wave takes across the body. At a touch there may be none yet.
class Invariants {
public:
  struct Defect {
    const char* name;
    double worst = 0; ///< over the steps so far
    int step = 0;     ///< of the worst
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

  /// Of the last frame: momentum defect; largest of the contact defects.
  [[nodiscard]] double momentum() const { return now_[1]; }
  [[nodiscard]] double complementarity() const;

  /// Largest energy of the run so far, J (in 2D J/m).
  [[nodiscard]] double largest_energy() const { return energy_; }

private:
  const step::Stepper& stepper_;
  double stiffness_ = 0;   ///< largest diagonal entry of A, as its norm
  double mass_, crossing_; ///< of the body, kg (in 2D kg/m); of a wave, s
  double energy_ = 0, forces_ = 0, contact_force_ = 0;
  std::array<Defect, 5> defects_{{{"energy law, residual beyond rounding / largest energy"},
                                  {"momentum law, residual / largest forces"},
                                  {"penetration / diameter"},
                                  {"adhesion / force scale"},
                                  {"force x gap / (force scale x diameter)"}}};
  std::array<double, 5> now_{};
};

} // namespace signorini::diagnostics
