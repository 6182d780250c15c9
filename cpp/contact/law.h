// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"

/// The unilateral law of a row's multiplier λ and its gap g, 0 ≤ λ ⟂ g ≥ 0: what solvers and derivatives know
/// of contact without friction.
namespace signorini::contact::unilateral {

/// Whether a row with this gap needs no force.
inline bool open(double gap) { return !(gap < 0); }

/// Whether a row is closed after a primal-dual step that held it closed, or open, and found λ and g
/// (Hintermüller, Ito, Kunisch 2003).
inline bool closes(bool closed, double lambda, double gap) { return closed ? lambda > 0 : gap < 0; }

/// Whether λ and g obey the law, where forces up to `force` and gaps up to `gap` count as zero.
inline bool holds(double lambda, double g, double force, double gap) {
  return g >= -gap && lambda >= -force && (lambda <= force || g <= gap);
}

/// The status of a row that obeys it, where forces up to `force` and gaps up to `gap` count as zero.
inline Status status(double lambda, double g, double force, double gap) {
  return lambda > force ? Status::strong : g <= gap ? Status::weak : Status::open;
}

/// Whether a weak row is closed after a step of the one-sided derivative that held it closed, or open, and
/// found δλ and ν·δy: 0 ≤ δλ ⟂ −ν·δy ≥ 0, but for `force` and `motion`.
inline bool closes_to_first_order(bool closed, double lambda, double approach, double force, double motion) {
  return closed ? lambda >= -force : approach > motion;
}

} // namespace signorini::contact::unilateral
