// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/linear_solver.h"
#include <functional>
#include <limits>
#include <memory>
#include <optional>

namespace signorini {

/// Preconditioner of conjugate gradients for one symmetric positive definite matrix, set up once. PETSc
/// options with the prefix `-step_pc_` are honoured.
class Preconditioner {
public:
  enum class Kind {
    block_jacobi, ///< one block per node: does not depend on the number of ranks
    multigrid     ///< smoothed aggregation (PETSc's GAMG) by the matrix's near null space, the rigid motions
  };

  /// `matrix`, in blocks, must outlive this object unchanged. Collective. Throws SolverFailure.
  Preconditioner(Mat matrix, Kind kind);

  /// Whether the PETSc options set a type, which replaces that of any kind.
  [[nodiscard]] static bool given_by_options();

  /// y = the preconditioner's x. Collective.
  [[nodiscard]] PetscErrorCode apply(Vec x, Vec y) const { return PCApply(preconditioner_, x, y); }

  [[nodiscard]] std::string name() const;

  /// Memory on all ranks as reported by PETSc, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  petsc::Matrix rows_; ///< copy of the matrix in the format that other types than block Jacobi need
  petsc::Preconditioner preconditioner_;
};

/// Preconditioned conjugate gradients. The preconditioner, set up once, is block Jacobi, or multigrid if by a
/// trial the expected solves take less work with it, set-up included. PETSc options with the prefix `-step_`
/// are honoured, except for the convergence test. The residual in the norm of the preconditioner (natural
/// norm), about the energy norm of the error, must fall below tolerance() times the energy norm of the guess
/// or, where that is larger, the residual of the guess.
class ConjugateGradients final : public LinearSolver {
public:
  /// Orthogonal projector onto a subspace of vectors, in place.
  using Projector = std::function<void(Vec)>;
  /// Inspects an iterate and returns whether to continue.
  using TerminationTest = std::function<bool(Vec)>;

  /// `matrix` must outlive this object unchanged; `solves`: expected number; `most`: work after which a trial
  /// solve is given up, in iterations by block Jacobi. Collective. Throws SolverFailure.
  explicit ConjugateGradients(Mat matrix, double solves = 1,
                              double most = std::numeric_limits<double>::infinity());
  ConjugateGradients(const ConjugateGradients&) = delete; // PETSc stores its address
  ConjugateGradients& operator=(const ConjugateGradients&) = delete;

  void solve(Vec b, Vec x) const override;

  /// Solves on a subspace: P (b − matrix x) = 0 with x − guess in the range of P. `judge`, if given, is
  /// called at two intermediate residuals; if it returns false, the solve ends there and returns false.
  /// Collective. Throws SolverFailure.
  bool solve(Vec b, Vec x, const Projector& project, const TerminationTest& judge) const;

  /// Work of a trial solve for equal forces in all unknowns from zero, in iterations by block Jacobi;
  /// infinity if it was given up. The same on every rank.
  [[nodiscard]] double trial_work() const { return trial_work_; }

  /// Bytes that an iteration by block Jacobi reads and writes, on all ranks. Collective.
  [[nodiscard]] static double iteration_bytes(Mat matrix);

  /// Relative tolerance of a solve (-step_ksp_rtol).
  [[nodiscard]] double tolerance() const { return tolerance_; }

  [[nodiscard]] std::string name() const override { return "CG with " + preconditioner_->name(); }
  [[nodiscard]] double bytes() const override { return preconditioner_->bytes(); }

private:
  /// State of one solve.
  struct Solve {
    const Projector* project = nullptr;
    const TerminationTest* judge = nullptr;
    std::ptrdiff_t asked = 0; ///< number of judged_at passed at the last call of the judge
    bool stopped = false;     ///< ended by the judge
    bool started = false;     ///< whether the guess was multiplied
    double scale = 0;         ///< norm of the solution to which residuals are relative
    /// Most iterations of a trial, which is not counted and may end without a solution.
    std::optional<double> most{};
  };

  [[nodiscard]] PetscErrorCode project(Vec x) const;
  static PetscErrorCode multiply(Mat shell, Vec x, Vec y);
  static PetscErrorCode precondition(PC shell, Vec x, Vec y);
  static PetscErrorCode converged(KSP ksp, PetscInt iteration, PetscReal residual, KSPConvergedReason* reason,
                                  void* context);
  void choose_preconditioner(Mat matrix, double solves, double most);
  /// Iterations of a trial, infinity if it takes more than `most` or fails.
  [[nodiscard]] double try_out(double most) const;
  void run(Vec b, Vec x, Solve& solve) const;

  Mat matrix_;
  /// P matrix, so that residuals stay in the subspace. Projected in the preconditioner P M⁻¹ P alone they
  /// would contain the forces f of the constraints. Once the rest of the residual has fallen to ε|f|, with ε
  /// the rounding of P, z·r would be rounding, and directions would leave the subspace (Gould, Hribar,
  /// Nocedal 2001). With both projections only the rounding ε²|f| is left.
  petsc::Matrix operator_;
  petsc::LinearSolver ksp_;
  std::unique_ptr<Preconditioner> preconditioner_;
  petsc::Vector right_hand_side_, projected_; ///< scratch of solves on a subspace
  mutable Solve* now_ = nullptr;              ///< the solve under way
  double tolerance_ = 0;
  double trial_work_ = 0; ///< trial work by the chosen preconditioner
};

} // namespace signorini
