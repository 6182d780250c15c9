// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include <array>
#include <cmath>

namespace signorini::contact {

/// Row c of A x or, if `transposed`, of Aᵀ x, for a (k × k) matrix A of a LawEquation.
[[nodiscard]] inline double times(const std::array<double, 9>& A, std::size_t k, std::size_t c,
                                  const std::array<double, 3>& x, bool transposed = false) {
  double sum = 0;
  for (std::size_t j = 0; j < k; ++j)
    sum += A[transposed ? j * k + c : c * k + j] * x[j];
  return sum;
}

/// Euclidean length of the entries of a few rows.
[[nodiscard]] inline double length(std::span<const double> x) {
  double square = 0;
  for (const double entry : x)
    square += entry * entry;
  return std::sqrt(square);
}

/// Change of a group's gaps per unit of its multipliers, along the normal and the mean of those along the
/// tangents.
struct Compliance {
  double normal, tangential;
};

/// Contact law between the multipliers ρ and the gaps U of a group of rows. Solvers and derivatives access
/// contact laws only through this interface. Spans have one entry for each row of the group, with the normal
/// row first. `friction`: of the group in the step, as ContactState::friction; laws without friction ignore
/// it.
class Law {
public:
  virtual ~Law() = default;

  /// Whether a group has a single row, with zero gap and an arbitrary multiplier in contact. Then the active
  /// set describes the law completely, and the linear systems are symmetric.
  [[nodiscard]] virtual bool symmetric() const = 0;

  /// Whether the law has forces on groups that are not in contact.
  [[nodiscard]] virtual bool acts_open() const { return false; }

  /// Bound of the tangential multipliers for the normal multiplier `lambda`; 0 without friction.
  [[nodiscard]] virtual double bound([[maybe_unused]] double friction, [[maybe_unused]] double lambda) const {
    return 0;
  }

  /// Whether a group stays open if its gaps are U (m) in the motion without contact forces.
  [[nodiscard]] virtual bool stays_open(std::span<const double> U) const = 0;

  /// Whether the row of a symmetric law belongs to the next active set, after a primal-dual step with the
  /// result `lambda` and `gap`. `closed`: whether the row was in the active set of this step.
  [[nodiscard]] virtual bool closes(bool closed, double lambda, double gap) const = 0;

  /// Sets `equation` to the law's equation for a Newton step from (ρ, U). `compliance`: of the group; it need
  /// not be exact. Returns false if the step opens the group; its multipliers then become zero, and
  /// `equation` is not used.
  [[nodiscard]] virtual bool newton_equation(std::span<const double> rho, std::span<const double> U,
                                             Compliance compliance, double friction,
                                             LawEquation& equation) const = 0;

  /// Residual of the law, m: zero if and only if ρ and U satisfy it. `compliance`: as for newton_equation().
  [[nodiscard]] virtual double residual(std::span<const double> rho, std::span<const double> U,
                                        Compliance compliance, double friction) const = 0;

  /// Whether ρ and U satisfy the law; multipliers up to `force` and gaps up to `gap` (m) count as zero.
  [[nodiscard]] virtual bool holds(std::span<const double> rho, std::span<const double> U, double friction,
                                   double force, double gap) const = 0;

  /// Status of a group that satisfies its law; multipliers up to `force` and gaps up to `gap` (m) count as
  /// zero.
  [[nodiscard]] virtual Status status(std::span<const double> rho, std::span<const double> U, double force,
                                      double gap) const = 0;

  /// Linearises the law of an active group in contact at its solution (ρ, U): E δU + F δρ = 0. Slips up to
  /// `gap` (m) count as zero. `compliance`: as for newton_equation(); it scales the rows.
  [[nodiscard]] virtual LawEquation linearised(std::span<const double> rho, std::span<const double> U,
                                               Compliance compliance, double friction, double gap) const = 0;

  /// Whether a weakly active row of a symmetric law belongs to the next closed set, after a step of the
  /// one-sided derivative with the result δλ = `lambda` and −δg = `approach`. `closed`: whether the row was
  /// closed in this step. Multipliers up to `force` and motions up to `motion` count as zero.
  [[nodiscard]] virtual bool closes_to_first_order(bool closed, double lambda, double approach, double force,
                                                   double motion) const = 0;
};

/// Contact without friction: 0 ≤ λ ⟂ g ≥ 0 (Hintermüller, Ito, Kunisch 2003). To first order a weakly active
/// row obeys 0 ≤ δλ ⟂ δg ≥ 0.
class Unilateral final : public Law {
public:
  [[nodiscard]] bool symmetric() const override { return true; }
  [[nodiscard]] bool stays_open(std::span<const double> U) const override { return !(U[0] < 0); }
  [[nodiscard]] bool closes(bool closed, double lambda, double gap) const override {
    return closed ? lambda > 0 : gap < 0;
  }
  [[nodiscard]] bool newton_equation(std::span<const double> rho, std::span<const double> U,
                                     Compliance compliance, double friction,
                                     LawEquation& equation) const override {
    equation = linearised(rho, U, compliance, friction, 0);
    return compliance.normal * rho[0] > U[0];
  }
  [[nodiscard]] double residual(std::span<const double> rho, std::span<const double> U, Compliance compliance,
                                double) const override {
    return std::abs(std::min(compliance.normal * rho[0], U[0]));
  }
  [[nodiscard]] bool holds(std::span<const double> rho, std::span<const double> U, double, double force,
                           double gap) const override {
    return U[0] >= -gap && rho[0] >= -force && (rho[0] <= force || U[0] <= gap);
  }
  [[nodiscard]] Status status(std::span<const double> rho, std::span<const double> U, double force,
                              double gap) const override {
    return rho[0] > force ? Status::strong : U[0] <= gap ? Status::weak : Status::open;
  }
  [[nodiscard]] LawEquation linearised(std::span<const double>, std::span<const double>, Compliance, double,
                                       double) const override {
    LawEquation equation;
    equation.E[0] = 1;
    return equation;
  }
  [[nodiscard]] bool closes_to_first_order(bool closed, double lambda, double approach, double force,
                                           double motion) const override {
    return closed ? lambda >= -force : approach > motion;
  }
};

inline const Unilateral unilateral;

} // namespace signorini::contact
