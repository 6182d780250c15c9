// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include "linalg/dense.h"
#include <functional>
#include <span>

namespace signorini::contact {

/// Whether column j of N depends linearly on those of an unordered set.
using Depends = std::function<bool(const ActiveSet& set, int j)>;

/// Scratch of goldfarb_idnani(); with room for m columns, solves up to this size allocate nothing.
struct GoldfarbIdnaniWork {
  explicit GoldfarbIdnaniWork(std::size_t m = 0) : factor(m) { r.reserve(m); }
  UpdatedCholesky factor; ///< Cholesky factor of S_AA
  std::vector<double> r;
};

/// A column of S, for rows that are members of a set or penetrate.
using Columns = std::function<std::span<const double>(int row)>;

/// Solves 0 ≤ λ ⟂ g⁰ + Sλ ≥ 0 by the dual active-set method of Goldfarb and Idnani (1983), for a symmetric S
/// = NᵀKN (m × m) with K positive definite. S is singular if the columns of N are linearly dependent. The
/// method ends after finitely many steps with the solution or the proof that there is none. Its active sets
/// are independent throughout. Finds the active set, ascending, and λ (m); negative gaps above −`tolerance`
/// count as zero. Returns false if there is no λ. Adds the number of steps to `steps`. Throws SolverFailure
/// if rounding keeps the search from ending or S_AA is singular.
[[nodiscard]] bool goldfarb_idnani(const Columns& S, std::span<const double> gap0, double tolerance,
                                   const Depends& depends, ActiveSet& set, std::span<double> lambda,
                                   int& steps, GoldfarbIdnaniWork& work);

} // namespace signorini::contact
