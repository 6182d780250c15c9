// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/law.h"

namespace signorini::contact {

/// Contact with friction (docs/method.md section 2). The rows of a group are the normal and up to two
/// orthonormal tangents, ρ = (λ, σ), U = (g, −w) with the slip w in the step. The normal row obeys
/// 0 ≤ λ ⟂ g ≥ 0, the others |σ| ≤ s, with σ = s w/|w| where w ≠ 0. The bound s is that of the derived law.
/// Newton steps and linearised laws are those of Alart and Curnier (1991).
class Friction : public Law {
public:
  [[nodiscard]] bool symmetric() const override { return false; }
  /// Not for these laws, which are not symmetric. Throws std::logic_error.
  [[nodiscard]] bool closes(bool closed, double lambda, double gap) const override;
  [[nodiscard]] bool newton_equation(std::span<const double> rho, std::span<const double> U,
                                     Compliance compliance, double friction,
                                     LawEquation& equation) const override;
  [[nodiscard]] bool holds(std::span<const double> rho, std::span<const double> U, double friction,
                           double force, double gap) const override;
  [[nodiscard]] Status status(std::span<const double> rho, std::span<const double> U, double force,
                              double gap) const override {
    return unilateral.status(rho, U, force, gap);
  }
  [[nodiscard]] LawEquation linearised(std::span<const double> rho, std::span<const double> U,
                                       Compliance compliance, double friction, double gap) const override;
  /// Not for these laws, which are not symmetric. Throws std::logic_error.
  [[nodiscard]] bool closes_to_first_order(bool closed, double lambda, double approach, double force,
                                           double motion) const override;

protected:
  /// Change of the bound per unit of λ.
  [[nodiscard]] virtual double bound_rate(double friction) const = 0;
};

/// Coulomb friction, s = μ λ. The residual is that of De Saxcé and Feng (1998).
class Coulomb final : public Friction {
public:
  [[nodiscard]] double bound(double friction, double lambda) const override { return friction * lambda; }
  [[nodiscard]] bool stays_open(std::span<const double> U) const override { return unilateral.stays_open(U); }
  [[nodiscard]] double residual(std::span<const double> rho, std::span<const double> U, Compliance compliance,
                                double friction) const override;

protected:
  [[nodiscard]] double bound_rate(double friction) const override { return friction; }
};

/// Tresca friction: s is given, and acts whether or not the candidate is in contact.
class Tresca final : public Friction {
public:
  [[nodiscard]] bool acts_open() const override { return true; }
  [[nodiscard]] double bound(double friction, double) const override { return friction; }
  [[nodiscard]] bool stays_open(std::span<const double> U) const override {
    return unilateral.stays_open(U) && length(U.subspan(1)) == 0;
  }
  [[nodiscard]] double residual(std::span<const double> rho, std::span<const double> U, Compliance compliance,
                                double friction) const override;

protected:
  [[nodiscard]] double bound_rate(double) const override { return 0; }
};

inline const Coulomb coulomb;
inline const Tresca tresca;

} // namespace signorini::contact
