// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include <array>

namespace signorini::contact {

/// Row c of a (k × k) matrix of an equation, or of its transpose, times x.
[[nodiscard]] inline double times(const std::array<double, 9>& A, std::size_t k, std::size_t c,
                                  const std::array<double, 3>& x, bool transposed = false) {
  double sum = 0;
  for (std::size_t j = 0; j < k; ++j)
    sum += A[transposed ? j * k + c : c * k + j] * x[j];
  return sum;
}

/// The law between the multipliers ρ and the gaps U of a group of rows. Solvers and derivatives access
/// contact only through it. Spans have an entry for each row of the group, the normal one first.
class Law {
public:
  virtual ~Law() = default;

  /// Whether an active group is one row whose gap is closed, whatever its multiplier: active sets then
  /// describe the law, and its systems are symmetric.
  [[nodiscard]] virtual bool symmetric() const = 0;

  /// Whether a group with these gaps needs no multipliers.
  [[nodiscard]] virtual bool open(std::span<const double> U) const = 0;

  /// Whether a row of a symmetric law is closed after a primal-dual step that found λ and g; `closed`:
  /// whether it was closed in this step.
  [[nodiscard]] virtual bool closes(bool closed, double lambda, double gap) const = 0;

  /// Sets the equation of a Newton step from (ρ, U), where a unit multiplier changes its gap by `compliance`.
  /// Returns false if the group is open, ρ = 0.
  [[nodiscard]] virtual bool next(std::span<const double> rho, std::span<const double> U, double compliance,
                                  LawEquation& equation) const = 0;

  /// Whether ρ and U obey the law, where multipliers up to `force` and gaps up to `gap` count as zero.
  [[nodiscard]] virtual bool holds(std::span<const double> rho, std::span<const double> U, double force,
                                   double gap) const = 0;

  /// Status of a group whose law is satisfied; multipliers up to `force` and gaps up to `gap` count as zero.
  [[nodiscard]] virtual Status status(std::span<const double> rho, std::span<const double> U, double force,
                                      double gap) const = 0;

  /// The law of an active group linearised at its solution, E δU + F δρ = c with c = 0.
  [[nodiscard]] virtual LawEquation linearised(std::span<const double> rho,
                                               std::span<const double> U) const = 0;

  /// Whether a weak row of a symmetric law is closed after a step of the one-sided derivative that found δλ
  /// and the approach −δg; `closed`: whether it was closed in this step. Multipliers up to `force` and
  /// motions up to `motion` count as zero.
  [[nodiscard]] virtual bool closes_to_first_order(bool closed, double lambda, double approach, double force,
                                                   double motion) const = 0;
};

/// Contact without friction: 0 ≤ λ ⟂ g ≥ 0 (Hintermüller, Ito, Kunisch 2003), and for weak rows
/// 0 ≤ δλ ⟂ δg ≥ 0.
class Unilateral final : public Law {
public:
  [[nodiscard]] bool symmetric() const override { return true; }
  [[nodiscard]] bool open(std::span<const double> U) const override { return !(U[0] < 0); }
  [[nodiscard]] bool closes(bool closed, double lambda, double gap) const override {
    return closed ? lambda > 0 : gap < 0;
  }
  [[nodiscard]] bool next(std::span<const double> rho, std::span<const double> U, double compliance,
                          LawEquation& equation) const override {
    equation = linearised(rho, U);
    return compliance * rho[0] > U[0];
  }
  [[nodiscard]] bool holds(std::span<const double> rho, std::span<const double> U, double force,
                           double gap) const override {
    return U[0] >= -gap && rho[0] >= -force && (rho[0] <= force || U[0] <= gap);
  }
  [[nodiscard]] Status status(std::span<const double> rho, std::span<const double> U, double force,
                              double gap) const override {
    return rho[0] > force ? Status::strong : U[0] <= gap ? Status::weak : Status::open;
  }
  [[nodiscard]] LawEquation linearised(std::span<const double>, std::span<const double>) const override {
    return {.E = {1}, .F = {}, .c = {}};
  }
  [[nodiscard]] bool closes_to_first_order(bool closed, double lambda, double approach, double force,
                                           double motion) const override {
    return closed ? lambda >= -force : approach > motion;
  }
};

inline const Unilateral unilateral;

} // namespace signorini::contact
