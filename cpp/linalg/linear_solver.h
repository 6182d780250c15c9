// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "base/timers.h"
#include <string>

namespace signorini {

/// Solver for one symmetric positive definite matrix, set up once and used at every step.
class LinearSolver {
public:
  /// Prefix of its options in PETSc's database.
  static constexpr const char* prefix = "step_";

  virtual ~LinearSolver() = default;

  /// Solves matrix x = b; `x` contains an initial guess on entry, which a direct solver ignores. Collective.
  /// Throws SolverFailure.
  virtual void solve(Vec b, Vec x) const = 0;

  /// Name for reports: the package, or the method and its preconditioner.
  [[nodiscard]] virtual std::string name() const = 0;

  /// Memory of the factor or preconditioner on all ranks, bytes. Collective.
  [[nodiscard]] virtual double bytes() const = 0;

protected:
  static void count_solves(long made = 1) { solves_ += made; }

private:
  inline static long& solves_ = count("solves with D");
};

/// Work of a factorisation, as estimated by its analysis.
struct FactorWork {
  double flops = 0;   ///< operations of the factorisation
  double entries = 0; ///< entries of the factor
};

} // namespace signorini
