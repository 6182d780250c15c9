// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/linear_solver.h"
#include <functional>
#include <limits>
#include <memory>
#include <optional>

namespace signorini {

/// Preconditioner of conjugate gradients for one symmetric positive definite matrix, set up once for many
/// solves. PETSc options with the prefix `-step_pc_` are honoured.
class Preconditioner {
public:
  enum class Kind {
    block_jacobi, ///< one block per node: independent of the number of ranks
    multigrid     ///< smoothed aggregation (PETSc's GAMG) with the near null space (rigid motions)
  };

  /// Sets up the preconditioner. The block size of `matrix` must be the number of components of a node.
  /// `matrix` must outlive this object unchanged. Collective. Throws SolverFailure.
  Preconditioner(Mat matrix, Kind kind);

  /// Whether the user has set -step_pc_type, which overrides every Kind.
  [[nodiscard]] static bool given_by_options();

  /// Applies the preconditioner to x and writes the result to y. Returns PETSc's error code. Collective.
  [[nodiscard]] PetscErrorCode apply(Vec x, Vec y) const { return PCApply(preconditioner_, x, y); }

  [[nodiscard]] std::string name() const;

  /// Memory on all ranks, estimated from the sizes that PETSc reports, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  petsc::Matrix rows_; ///< AIJ copy of the matrix; null for block Jacobi, which needs none
  petsc::Preconditioner preconditioner_;
};

/// Solver by preconditioned conjugate gradients. The constructor makes trial solves and selects the
/// preconditioner: multigrid if the expected solves, set-up included, take less work with it, else block
/// Jacobi. PETSc options with the prefix `-step_` are honoured, except for the convergence test.
///
/// Convergence test: the residual in the natural norm (that of the preconditioner, which approximates the
/// energy norm of the error) must fall below tolerance() times a reference. This reference is the larger of
/// the energy norm of the initial guess and the natural norm of the initial residual.
class ConjugateGradients final : public LinearSolver {
public:
  /// Replaces a vector by its orthogonal projection onto a subspace.
  using Projector = std::function<void(Vec)>;
  /// Inspects an iterate and returns whether to continue.
  using TerminationTest = std::function<bool(Vec)>;

  /// Selects and sets up the preconditioner. `matrix` must outlive this object unchanged; `solves`: expected
  /// number of solves; `most`: work after which a trial solve is abandoned, in iterations with block Jacobi.
  /// Collective. Throws SolverFailure.
  explicit ConjugateGradients(Mat matrix, double solves = 1,
                              double most = std::numeric_limits<double>::infinity());
  ConjugateGradients(const ConjugateGradients&) = delete; // PETSc stores its address
  ConjugateGradients& operator=(const ConjugateGradients&) = delete;

  void solve(Vec b, Vec x) const override;

  /// Solves P (matrix x − b) = 0, where `project` applies P, the orthogonal projector onto a subspace. The
  /// solution differs from the initial guess by a vector of the subspace. `termination_test`, if given,
  /// inspects at most two intermediate iterates. If it returns false, the solve ends with that iterate as x,
  /// and solve() returns false. Otherwise solve() returns true. Collective. Throws SolverFailure.
  bool solve(Vec b, Vec x, const Projector& project, const TerminationTest& termination_test) const;

  /// Work of the trial solve (right-hand side 1 in all unknowns, guess zero) without set-up, in iterations
  /// with block Jacobi; infinity if it was abandoned. The same on every rank.
  [[nodiscard]] double trial_work() const { return trial_work_; }

  /// Memory traffic of one iteration with block Jacobi for `matrix`, on all ranks, bytes. Collective.
  [[nodiscard]] static double iteration_bytes(Mat matrix);

  /// Relative tolerance of the convergence test (-step_ksp_rtol).
  [[nodiscard]] double tolerance() const { return tolerance_; }

  /// Matrix for products with the operator: its upper half if it is given in blocks.
  [[nodiscard]] Mat product() const { return half_ ? Mat(half_) : matrix_; }

  [[nodiscard]] std::string name() const override { return "CG with " + preconditioner_->name(); }
  [[nodiscard]] double bytes() const override {
    return preconditioner_->bytes() + (half_ ? petsc::bytes(half_) : 0);
  }

private:
  /// State of one solve.
  struct Solve {
    const Projector* project = nullptr;
    const TerminationTest* termination_test = nullptr;
    /// Number of limits in judged_at reached when termination_test was last called.
    std::ptrdiff_t limits_passed = 0;
    bool stopped = false; ///< whether termination_test has ended the solve
    bool started = false; ///< whether the matrix has been applied to the guess
    double scale = 0;     ///< reference of the convergence test
    /// Limit of the iterations of a trial solve, which is not counted and may end without a solution. Absent
    /// for other solves.
    std::optional<double> most{};
  };

  [[nodiscard]] PetscErrorCode project(Vec x) const;
  static PetscErrorCode multiply(Mat shell, Vec x, Vec y);
  static PetscErrorCode precondition(PC shell, Vec x, Vec y);
  static PetscErrorCode converged(KSP ksp, PetscInt iteration, PetscReal residual, KSPConvergedReason* reason,
                                  void* context);
  void choose_preconditioner(Mat matrix, double solves, double most);
  /// Makes a trial solve and returns the number of its iterations; infinity if it exceeds `most` or fails.
  [[nodiscard]] double try_out(double most) const;
  void run(Vec b, Vec x, Solve& solve) const;

  Mat matrix_;
  petsc::Matrix half_; ///< upper half of matrix_ for products; null for matrices without blocks
  /// The operator x ↦ P (matrix x), which keeps residuals r in the subspace. With the projection in the
  /// preconditioner alone, z = P M⁻¹ P r, residuals would contain the constraint forces f. Once the rest of
  /// the residual has fallen to ε|f|, with ε the rounding error of P, z·r would be rounding error, and search
  /// directions would leave the subspace (Gould, Hribar, Nocedal 2001). With both projections only a rounding
  /// error of ε²|f| remains.
  petsc::Matrix operator_;
  petsc::LinearSolver ksp_;
  std::unique_ptr<Preconditioner> preconditioner_;
  petsc::Vector right_hand_side_, projected_; ///< scratch of solves on a subspace
  mutable Solve* now_ = nullptr;              ///< the solve in progress, else null
  double tolerance_ = 0;
  double trial_work_ = 0; ///< work of the trial solve with the selected preconditioner
};

} // namespace signorini
