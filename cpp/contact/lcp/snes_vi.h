// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include <string>

namespace signorini::contact {

/// Solves a variational inequality with simple bounds by PETSc's reduced-space Newton method (Benson, Munson
/// 2006): find x with lower ≤ x ≤ upper for which K x + c is zero between the bounds, ≥ 0 at a lower bound
/// and ≤ 0 at an upper bound. Scale the problem so that a distance of 1 from a bound and a residual of 1 are
/// negligible. By default the method counts x as on a bound within a distance of 0.001, and stops at a
/// residual norm of 0.01.
class SnesVi {
public:
  /// Takes ownership of the bounds; `K` must outlive this object unchanged. PETSc options with the prefix
  /// `-<name>_` are honoured. `package`: default package for factorising submatrices of K. Collective.
  SnesVi(const std::string& name, Mat K, petsc::Vector lower, petsc::Vector upper, const char* package);

  /// Solves for `x`, starting from its value on entry. Returns the number of Newton steps. Collective. Throws
  /// SolverFailure that states the reason and the residual.
  int solve(Vec c, Vec x) const;

  /// K x + c for the last solution x.
  [[nodiscard]] Vec residual() const { return residual_; }
  [[nodiscard]] Vec upper() const { return upper_; }

private:
  std::string name_;
  petsc::Vector lower_, upper_, residual_, constant_;
  petsc::NonlinearSolver snes_;
};

} // namespace signorini::contact
