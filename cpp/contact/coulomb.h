// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/law.h"

namespace signorini::contact {

/// Contact with Coulomb friction (docs/method.md section 2). The rows of a group are the normal and up to two
/// orthonormal tangents, ρ = (λ, σ), U = (g, −w) with the slip w in the step. The normal row obeys
/// 0 ≤ λ ⟂ g ≥ 0, the others |σ| ≤ μ λ, with σ = μ λ w/|w| where w ≠ 0. Newton steps and linearised laws are
/// those of Alart and Curnier (1991), the residual is that of De Saxcé and Feng (1998).
class Coulomb final : public Law {
public:
  [[nodiscard]] bool symmetric() const override { return false; }
  [[nodiscard]] bool stays_open(std::span<const double> U) const override { return unilateral.stays_open(U); }
  /// Not for this law, which is not symmetric. Throws std::logic_error.
  [[nodiscard]] bool closes(bool closed, double lambda, double gap) const override;
  [[nodiscard]] bool newton_equation(std::span<const double> rho, std::span<const double> U,
                                     double compliance, double friction,
                                     LawEquation& equation) const override;
  [[nodiscard]] double residual(std::span<const double> rho, std::span<const double> U, double compliance,
                                double friction) const override;
  [[nodiscard]] bool holds(std::span<const double> rho, std::span<const double> U, double friction,
                           double force, double gap) const override;
  [[nodiscard]] Status status(std::span<const double> rho, std::span<const double> U, double force,
                              double gap) const override {
    return unilateral.status(rho, U, force, gap);
  }
  [[nodiscard]] LawEquation linearised(std::span<const double> rho, std::span<const double> U,
                                       double compliance, double friction, double gap) const override;
  /// Not for this law, which is not symmetric. Throws std::logic_error.
  [[nodiscard]] bool closes_to_first_order(bool closed, double lambda, double approach, double force,
                                           double motion) const override;
};

inline const Coulomb coulomb;

} // namespace signorini::contact
