// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include "linalg/dense.h"
#include <functional>
#include <span>

namespace signorini::contact {

/// Whether column j of N depends linearly on the columns of a set, whose members may be in any order.
using Depends = std::function<bool(const ActiveSet& set, int j)>;

/// Scratch of goldfarb_idnani(). Solves with up to `m` columns allocate no memory.
struct GoldfarbIdnaniWork {
  explicit GoldfarbIdnaniWork(std::size_t m = 0) : factor(m) { r.reserve(m); }
  UpdatedCholesky factor; ///< Cholesky factor of S_AA
  std::vector<double> r;
};

/// Function that returns column `row` of S. It is called only for rows that are in the active set or
/// penetrate.
using Columns = std::function<std::span<const double>(int row)>;

/// Solves 0 ≤ λ ⟂ g⁰ + Sλ ≥ 0 by the dual active-set method of Goldfarb and Idnani (1983). S = NᵀKN (m × m)
/// with a symmetric positive definite K; it is singular if columns of N are linearly dependent. The method
/// ends after finitely many steps, with the solution or with the proof that there is none, and all of its
/// active sets are linearly independent.
///
/// On return `set` is the active set, ascending, and `lambda` is λ (m entries). Negative gaps above
/// −`tolerance` count as zero. Adds the number of steps to `steps`. Returns false if there is no solution.
/// Throws SolverFailure if rounding errors prevent the method from ending or if S_AA is singular.
[[nodiscard]] bool goldfarb_idnani(const Columns& S, std::span<const double> gap0, double tolerance,
                                   const Depends& depends, ActiveSet& set, std::span<double> lambda,
                                   int& steps, GoldfarbIdnaniWork& work);

} // namespace signorini::contact
