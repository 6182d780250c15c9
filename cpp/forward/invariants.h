#pragma once
#include "forward/balance.h"
#include <array>
#include <string>

namespace signorini::forward {

/// How well a motion keeps what its scheme keeps exactly (docs/method.md section 2): watched step by step, each
/// defect relative to what of its kind the run has seen so far.
class Invariants {
public:
  struct Defect {
    const char* name;
    double worst = 0; ///< over the steps so far
    int step = 0;     ///< where
  };

  /// Collective. `stepper` must outlive this object.
  explicit Invariants(const Stepper& stepper);

  /// Takes the frame after the last one and its balance.
  void observe(const Frame& frame, const StepBalance& balance);

  /// Energy law, momentum law; where there is contact penetration, adhesion and complementarity.
  [[nodiscard]] std::span<const Defect> defects() const {
    return {defects_.data(), stepper_.constraints() ? defects_.size() : 2};
  }

  /// The worst of the last frame's defects in a few words, if it is above `tolerance`.
  [[nodiscard]] std::optional<std::string> violation(double tolerance) const;

  /// Of the last frame: momentum defect; largest of the contact defects.
  [[nodiscard]] double momentum() const { return now_[1]; }
  [[nodiscard]] double complementarity() const;

  [[nodiscard]] double largest_energy() const { return energy_; }

private:
  const Stepper& stepper_;
  double stiffness_ = 0; ///< a norm of A
  double energy_ = 0, forces_ = 0, contact_force_ = 0;
  std::array<Defect, 5> defects_{{{"energy law, residual beyond rounding / largest energy"},
                                  {"momentum law, residual / largest forces"},
                                  {"penetration / diameter"},
                                  {"adhesion / largest force"},
                                  {"force x gap / (largest x diameter)"}}};
  std::array<double, 5> now_{};
};

} // namespace signorini::forward
