// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include <algorithm>
#include <iterator>
#include <limits>
#include <vector>

namespace signorini::contact {

/// Whether the force direction of candidate i depends linearly on the force directions of the members of
/// `set` that share unknowns with it (its cluster). `set` must be linearly independent and may be in any
/// order.
[[nodiscard]] bool depends(const ConstraintRows& rows, const ActiveSet& set, int i);

/// Removes from an ascending set the candidates that depend linearly on earlier members of their cluster
/// (rows that share unknowns).
void drop_dependent(const ConstraintRows& rows, ActiveSet& set);

/// Computes the active set that follows `set` in a primal-dual step, from the solution on `set` (linearly
/// independent, ascending). `next` contains the closed candidates with λ > 0 and the open ones with g < 0
/// (Hintermüller, Ito, Kunisch 2003), and is made linearly independent. If a candidate depends
/// linearly on others of its cluster (rows that share unknowns), it replaces one of them: the one whose force
/// becomes zero first while the force of the new one grows from zero (ratio test).
void next_set(const ConstraintRows& rows, const ActiveSet& set, std::span<const double> lambda,
              std::span<const double> gap, ActiveSet& next);

/// Block principal pivoting (Júdice, Pires 1994) for one solve. It takes whole primal-dual steps as long as
/// the number of candidates that a step would change has reached a new minimum within the last ten steps.
/// Otherwise each step changes one cluster only: among the candidates that the step would change, the cluster
/// of the one with the highest number. This ends after finitely many steps (Murty 1974).
class BlockPivoting {
public:
  /// Starts pivoting for one solve. `rows` must outlive this object.
  explicit BlockPivoting(const ConstraintRows& rows) : rows_(rows) {}

  /// Whether the next step changes all candidates at once (a whole primal-dual step).
  [[nodiscard]] bool whole() const { return left_ > 0; }
  [[nodiscard]] int steps() const { return steps_; }

  /// Replaces `set` by the next active set to try. On entry `next` is the set that a primal-dual step
  /// computes from `set`. On return `next` and `wrong` are scratch. Throws SolverFailure after too many
  /// steps.
  void advance(ActiveSet& set, ActiveSet& next, ActiveSet& wrong);

private:
  static constexpr int patience = 10;

  const ConstraintRows& rows_;
  std::size_t fewest_ = std::numeric_limits<std::size_t>::max();
  int left_ = patience, steps_ = 0;
};

/// Finds the candidates C among `closed` and `weak` that stay closed to first order, and replaces `closed` by
/// them: those of `weak` obey an inequality between force and motion, the others stay as they are. `solve`
/// solves on `closed`, stores the multipliers and Hᵀ of the solution in `force` and `motion` (rows), and
/// returns the scales of forces and motions. Throws SolverFailure. Collective if `solve` is.
template <class Solve>
void close_to_first_order(const ConstraintRows& rows, const ActiveSet& weak, ActiveSet& closed,
                          const std::vector<double>& force, const std::vector<double>& motion,
                          Solve&& solve) {
  constexpr double rounding = 1e-10;
  ActiveSet next, wrong, all;
  std::ranges::set_union(closed, weak, std::back_inserter(all));
  for (BlockPivoting pivoting(rows);; pivoting.advance(closed, next, wrong)) {
    const auto [largest_force, largest_motion] = solve();
    next.clear();
    for (const int i : all) {
      const auto at = static_cast<std::size_t>(i);
      const bool is_closed = std::ranges::binary_search(closed, i);
      if (std::ranges::binary_search(weak, i)
              ? rows.law(i).closes_to_first_order(is_closed, force[at], motion[at], rounding * largest_force,
                                                  rounding * largest_motion)
              : is_closed)
        next.push_back(i);
    }
    if (next == closed)
      return;
  }
}

} // namespace signorini::contact
