// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "forward/balance.h"
#include <array>
#include <string>

namespace signorini::forward {

/// Monitors what the scheme conserves exactly (docs/method.md section 2), step by step: each defect is
/// relative to the largest quantity of its kind in the run so far, or to the body's diameter.
class Invariants {
public:
  struct Defect {
    const char* name;
    double worst = 0; ///< over the steps so far
    int step = 0;     ///< of the worst
  };

  /// Collective. `stepper` must outlive this object.
  explicit Invariants(const Stepper& stepper);

  /// Updates the defects by the frame that follows the last one, and its balance.
  void observe(const Frame& frame, const StepBalance& balance);

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
  const Stepper& stepper_;
  double stiffness_ = 0; ///< largest diagonal entry of A, as its norm
  double energy_ = 0, forces_ = 0, contact_force_ = 0;
  std::array<Defect, 5> defects_{{{"energy law, residual beyond rounding / largest energy"},
                                  {"momentum law, residual / largest forces"},
                                  {"penetration / diameter"},
                                  {"adhesion / largest force"},
                                  {"force x gap / (largest x diameter)"}}};
  std::array<double, 5> now_{};
};

} // namespace signorini::forward
