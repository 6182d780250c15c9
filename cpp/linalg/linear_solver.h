// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "base/timers.h"
#include <string>

namespace signorini {

/// Solver for systems with one symmetric positive definite matrix, set up once and used in every step.
class LinearSolver {
public:
  /// Prefix of the solver's options in PETSc's database.
  static constexpr const char* prefix = "step_";

  virtual ~LinearSolver() = default;

  /// Solves matrix x = b. On entry `x` contains an initial guess, which direct solvers ignore. Collective.
  /// Throws SolverFailure.
  virtual void solve(Vec b, Vec x) const = 0;

  /// Name of the solver for reports: the package, or the method and its preconditioner.
  [[nodiscard]] virtual std::string name() const = 0;

  /// Memory of the factor or preconditioner, summed over all ranks, bytes. Collective.
  [[nodiscard]] virtual double bytes() const = 0;

protected:
  static void count_solves(long made = 1) { solves_ += made; }

private:
  inline static long& solves_ = count("solves with D");
};

/// Cost of a factorisation, as its analysis estimates it.
struct FactorWork {
  double flops = 0;   ///< floating-point operations
  double entries = 0; ///< stored entries of the factor
};

} // namespace signorini
