// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"

namespace signorini::contact {

/// The law between the multiplier λ of a row and its gap g: what solvers and derivatives know of contact.
class Law {
public:
  virtual ~Law() = default;

  /// Whether a row with this gap needs no multiplier.
  [[nodiscard]] virtual bool open(double gap) const = 0;

  /// Whether a row is closed after a primal-dual step that held it closed, or open, and found λ and g.
  [[nodiscard]] virtual bool closes(bool closed, double lambda, double gap) const = 0;

  /// Whether λ and g obey the law, where multipliers up to `force` and gaps up to `gap` count as zero.
  [[nodiscard]] virtual bool holds(double lambda, double g, double force, double gap) const = 0;

  /// The status of a row that obeys it, where multipliers up to `force` and gaps up to `gap` count as zero.
  [[nodiscard]] virtual Status status(double lambda, double g, double force, double gap) const = 0;

  /// Whether a weak row is closed after a step of the one-sided derivative that held it closed, or open, and
  /// found δλ and the approach −δg, where multipliers up to `force` and motions up to `motion` count as zero.
  [[nodiscard]] virtual bool closes_to_first_order(bool closed, double lambda, double approach, double force,
                                                   double motion) const = 0;
};

/// Contact without friction: 0 ≤ λ ⟂ g ≥ 0 (Hintermüller, Ito, Kunisch 2003), and of weak rows
/// 0 ≤ δλ ⟂ δg ≥ 0.
class Unilateral final : public Law {
public:
  [[nodiscard]] bool open(double gap) const override { return !(gap < 0); }
  [[nodiscard]] bool closes(bool closed, double lambda, double gap) const override {
    return closed ? lambda > 0 : gap < 0;
  }
  [[nodiscard]] bool holds(double lambda, double g, double force, double gap) const override {
    return g >= -gap && lambda >= -force && (lambda <= force || g <= gap);
  }
  [[nodiscard]] Status status(double lambda, double g, double force, double gap) const override {
    return lambda > force ? Status::strong : g <= gap ? Status::weak : Status::open;
  }
  [[nodiscard]] bool closes_to_first_order(bool closed, double lambda, double approach, double force,
                                           double motion) const override {
    return closed ? lambda >= -force : approach > motion;
  }
};

inline const Unilateral unilateral;

} // namespace signorini::contact
