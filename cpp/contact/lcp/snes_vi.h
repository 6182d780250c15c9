// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include <string>

namespace signorini::contact {

/// Solves the variational inequality of a matrix K with simple bounds by PETSc's reduced-space Newton method
/// (Benson, Munson 2006): find lower ≤ x ≤ upper with K x + c zero between the bounds, ≥ 0 at the lower and ≤
/// 0 at the upper one. The problem must be given in units in which a distance to a bound and a residual of
/// one are negligible: those below a thousandth count as zero.
class SnesVi {
public:
  /// Takes ownership of the bounds; `K` must outlive this object unchanged. PETSc options with the prefix
  /// `-<name>_` are honoured; `package` is the default one for factorising submatrices of K. Collective.
  SnesVi(const std::string& name, Mat K, petsc::Vector lower, petsc::Vector upper, const char* package);

  /// Solves for `x`, starting from its value on entry. Returns the number of Newton steps. Collective. Throws
  /// SolverFailure with reason and residual.
  int solve(Vec c, Vec x) const;

  /// K x + c of the last solution.
  [[nodiscard]] Vec residual() const { return residual_; }
  [[nodiscard]] Vec upper() const { return upper_; }

private:
  std::string name_;
  petsc::Vector lower_, upper_, residual_, constant_;
  petsc::NonlinearSolver snes_;
};

} // namespace signorini::contact
