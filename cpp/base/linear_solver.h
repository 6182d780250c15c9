#pragma once
#include "base/petsc.h"
#include <string>

namespace signorini {

/// A symmetric positive definite matrix, factorised once: CHOLMOD on one rank, MUMPS on several.
class Factorisation {
public:
  /// Factorises `matrix`, which must outlive this object unchanged. Collective.
  /// PETSc options with the prefix `-step_` are honoured. Throws SolverFailure.
  explicit Factorisation(Mat matrix);

  /// x = matrix⁻¹ b. Collective. Throws SolverFailure.
  void solve(Vec b, Vec x) const;

  /// Name of the package that factorised, for reports.
  [[nodiscard]] const std::string& package() const { return package_; }

private:
  petsc::LinearSolver ksp_;
  std::string package_;
};

} // namespace signorini
