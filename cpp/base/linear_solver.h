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

protected:
  static void count_solve();
};

/// Factorisation by MUMPS on any number of ranks. PETSc options with the prefix `-step_` are honoured.
class MumpsSolver final : public LinearSolver {
public:
  /// Orders and counts. Collective. Throws SolverFailure.
  explicit MumpsSolver(Mat matrix);

  /// Whether the factor's entries can be numbered: MUMPS does with 64 bits.
  [[nodiscard]] static bool possible() { return true; }

  /// Memory that the factorisation will take on all ranks, as counted, bytes. Collective.
  [[nodiscard]] double estimate() const;

  /// To be called once before solve(). Collective. Throws SolverFailure.
  void factorise();

  void solve(Vec b, Vec x) const override;
  [[nodiscard]] std::string name() const override { return "MUMPS"; }
  [[nodiscard]] double bytes() const override;

private:
  void analyse();
  [[nodiscard]] bool short_of_space() const;
  petsc::Matrix matrix_, factor_;
};

/// The method of conjugate gradients, its preconditioner set up once: block Jacobi, a block for each
/// node, the same on any number of ranks. PETSc options with the prefix `-step_` are honoured, but for the
/// convergence test: the residual in the norm of the preconditioner, which is about the error in the norm of
/// the matrix, falls below tolerance() times the solution's size.
class ConjugateGradients final : public LinearSolver {
public:
  /// Orthogonal projector onto a subspace of vectors, in place.
  using Projector = std::function<void(Vec)>;
  /// Looks at an unfinished solution and tells whether to go on with it.
  using Judge = std::function<bool(Vec)>;

  /// `matrix` must outlive this object unchanged. Collective. Throws SolverFailure.
  explicit ConjugateGradients(Mat matrix);
  ConjugateGradients(const ConjugateGradients&) = delete; // PETSc holds its address
  ConjugateGradients& operator=(const ConjugateGradients&) = delete;

  void solve(Vec b, Vec x) const override;

  /// Solves on a subspace: P (b − matrix x) = 0 with x − guess in the range of P. `judge`, if given, is asked
  /// on the way, and false ends the solve: then false is returned. Collective. Throws SolverFailure.
  bool solve(Vec b, Vec x, const Projector& project, const Judge& judge) const;

  /// Relative tolerance of a solve (-step_ksp_rtol).
  [[nodiscard]] double tolerance() const { return tolerance_; }

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] double bytes() const override;

private:
  /// The solve that is under way.
  struct Solve {
    const Projector* project = nullptr;
    const Judge* judge = nullptr;
    std::ptrdiff_t asked = 0; ///< residuals of judged_at passed when the judge was asked last
    bool stopped = false;     ///< by the judge
    double scale = 0;         ///< size of the solution in the norm of the residual
  };

  static PetscErrorCode precondition(PC shell, Vec x, Vec y);
  static PetscErrorCode converged(KSP ksp, PetscInt iteration, PetscReal residual, KSPConvergedReason* reason,
                                  void* context);
  void run(Vec b, Vec x, Solve solve) const;

  petsc::LinearSolver ksp_;
  petsc::Preconditioner preconditioner_;
  petsc::Vector projected_;
  double tolerance_ = 0;
  std::string name_;
  mutable Solve now_;
};

} // namespace signorini
