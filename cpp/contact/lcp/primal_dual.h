// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include <limits>

namespace signorini::contact {

/// Whether the direction of candidate i depends linearly on those of its cluster in an independent set, which
/// may be in any order.
[[nodiscard]] bool depends(const ConstraintRows& rows, const ActiveSet& set, int i);

/// Removes candidates that depend on earlier ones of their node.
void drop_dependent(const ConstraintRows& rows, ActiveSet& set);

/// The next set of a primal-dual step, independent, from the solution on an independent `set`: closed
/// candidates with λ > 0 and open ones with g < 0 (Hintermüller, Ito, Kunisch 2003). A candidate that depends
/// on others of its cluster replaces the one whose force falls to zero first as its own grows (ratio test).
void next_set(const ConstraintRows& rows, const ActiveSet& set, std::span<const double> lambda,
              std::span<const double> gap, ActiveSet& next);

/// Block principal pivoting (Júdice, Pires 1994): whole primal-dual steps as long as the number of candidates
/// on the wrong side reaches a new minimum every few steps. Otherwise one node at a time is changed,
/// that of the last candidate on the wrong side, which ends after finitely many steps (Murty 1974).
class BlockPivoting {
public:
  /// `rows` must outlive this object.
  explicit BlockPivoting(const ConstraintRows& rows) : rows_(rows) {}

  /// Whether the next step is a whole one.
  [[nodiscard]] bool whole() const { return left_ > 0; }
  [[nodiscard]] int steps() const { return steps_; }

  /// Replaces `set` by the next one to try. On entry `next` is the set of a primal-dual step from `set`; on
  /// return it is scratch, like `wrong`. Throws SolverFailure after too many steps.
  void advance(ActiveSet& set, ActiveSet& next, ActiveSet& wrong);

private:
  static constexpr int patience = 10;

  const ConstraintRows& rows_;
  std::size_t fewest_ = std::numeric_limits<std::size_t>::max();
  int left_ = patience, steps_ = 0;
};

} // namespace signorini::contact
