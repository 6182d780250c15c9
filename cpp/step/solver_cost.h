// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/linear_solver.h"

namespace signorini::step {

/// Seconds that a way to solve the steps of a run takes.
struct Price {
  double setup = 0, solve = 0;
  [[nodiscard]] double total(double solves) const { return setup + solves * solve; }
};

/// Work of a direct solver: factor and contact.
struct DirectWork {
  double setup_flops = 0;
  double solve_bytes = 0; ///< read by a solve

  /// `candidates`: m; `trailing_block`: unknowns of the candidates' nodes where these are last in the
  /// elimination order, else 0, and the columns of D⁻¹N are solved for.
  DirectWork(const FactorWork& factor, double candidates, double trailing_block);

  /// Whether set-up takes so little on any machine that nothing is to be gained by another way: the choice
  /// then depends on no clock.
  [[nodiscard]] bool small() const;
};

/// By rates of this machine, measured. Collective; the same on every rank.
Price price(MPI_Comm comm, const DirectWork& work);

/// Of conjugate gradients whose trial took so many seconds.
Price iterative_price(double trial);

/// Seconds that a solve by conjugate gradients may take in a trial in order to be chosen over `direct`.
double affordable(const Price& direct, double solves);

} // namespace signorini::step
