#pragma once
#include "base/petsc.h"
#include <functional>
#include <string>

namespace signorini {

/// Solver for one symmetric positive definite matrix, prepared once and used at every step.
class LinearSolver {
public:
  virtual ~LinearSolver() = default;

  /// x = matrix⁻¹ b; `x` holds a guess on entry, which a direct solver ignores. Collective. Throws
  /// SolverFailure.
  virtual void solve(Vec b, Vec x) const = 0;

  /// What solves, for reports: a package, or the method and its preconditioner.
  [[nodiscard]] virtual std::string name() const = 0;

  /// Memory of the factor or preconditioner on all ranks, bytes. Collective.
  [[nodiscard]] virtual double bytes() const = 0;
};

/// Factorisation by MUMPS on any number of ranks. PETSc options with the prefix `-step_` are honoured.
class MumpsSolver final : public LinearSolver {
public:
  /// Orders and counts. Collective. Throws SolverFailure.
  explicit MumpsSolver(Mat matrix);

  /// Memory that the factorisation will take on all ranks, as counted, bytes. Collective.
  [[nodiscard]] double estimate() const;

  /// To be called once before solve(). Collective. Throws SolverFailure.
  void factorise();

  void solve(Vec b, Vec x) const override;
  [[nodiscard]] std::string name() const override { return "MUMPS"; }
  [[nodiscard]] double bytes() const override;

private:
  petsc::Matrix matrix_, factor_;
};

/// The method of conjugate gradients, its preconditioner set up once: incomplete Cholesky of each rank's own
/// block. PETSc options with the prefix `-step_` are honoured.
class ConjugateGradients final : public LinearSolver {
public:
  /// Orthogonal projector onto a subspace of vectors, in place.
  using Projector = std::function<void(Vec)>;

  /// `matrix` must outlive this object unchanged. Collective. Throws SolverFailure.
  explicit ConjugateGradients(Mat matrix);
  ConjugateGradients(const ConjugateGradients&) = delete; // PETSc holds its address
  ConjugateGradients& operator=(const ConjugateGradients&) = delete;

  void solve(Vec b, Vec x) const override;

  /// Solves on a subspace: P (b − matrix x) = 0 with x − guess in the range of P, to a relative tolerance.
  /// Returns the iterations. Collective. Throws SolverFailure.
  int solve(Vec b, Vec x, const Projector& project, double tolerance) const;

  /// Relative tolerance of the residual of a whole solve, in the norm of the preconditioner.
  [[nodiscard]] double tolerance() const { return tolerance_; }

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] double bytes() const override;

private:
  static PetscErrorCode precondition(PC shell, Vec x, Vec y);

  petsc::LinearSolver ksp_;
  petsc::Preconditioner preconditioner_;
  petsc::Vector projected_;
  double tolerance_ = 0;
  std::string name_;
  mutable const Projector* project_ = nullptr; ///< of the solve that is under way
};

} // namespace signorini
