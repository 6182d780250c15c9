// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"
#include "contact/solver/condensed.h"
#include "linalg/conjugate_gradients.h"
#include "linalg/mumps_solver.h"
#include "linalg/sparse_cholesky.h"
#include <memory>
#include <string>

namespace signorini::step {

/// Work of a way to solve the steps of a run, in seconds of a machine whose rates are fixed, so that a choice
/// is the same on every machine and under any load.
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

  /// Whether set-up takes so little that nothing is to be gained by another way.
  [[nodiscard]] bool small() const;
};

/// Price of a factorisation by CHOLMOD, on one rank, or by MUMPS.
Price price(const DirectWork& work, int ranks);

/// Price of conjugate gradients with an iteration of so many bytes, whose trial took this work
/// (ConjugateGradients::trial_work()).
Price iterative_price(double trial_work, double iteration_bytes, int ranks);

/// Work of a trial of conjugate gradients for which they are chosen over `direct`.
double affordable(const Price& direct, double solves, double iteration_bytes, int ranks);

/// Bytes that a factor of a matrix on one rank takes at least, without an analysis: by the layers of its
/// graph around a node as far out as possible; 0 where the graph is not known. Not collective.
double least_factor_bytes(Mat D);

/// The solvers of a run's steps, as the scene's [solver] asks: a factorisation (CHOLMOD on one rank, MUMPS on
/// several) with contact condensed to the candidates, or conjugate gradients where the factor would not fit
/// the memory allowed or would take clearly longer.
class SolverChoice {
public:
  /// Estimates the factor's memory and time, chooses a solver and factorises. `pairs` is null without
  /// contact; `derivatives`: linearised or transposed steps are wanted; `solves`: expected, by which times
  /// are compared, 0 to choose by memory alone. Collective, with the same choice on every rank. The
  /// references must outlive this object. `order`: the elimination order of a matrix with the same entries,
  /// if one is known; `residual`: of D, which is not kept where it is factorised, for CondensedSolver. Throws
  /// SolverFailure.
  SolverChoice(petsc::Matrix D, const contact::ContactPairs* pairs, const scene::Solver& scene,
               bool derivatives, double solves = 0, const EliminationOrder& order = {},
               contact::Residual residual = {});

  /// Whether D is not factorised.
  [[nodiscard]] bool iterates() const { return iterative_ != nullptr; }
  /// Solves with D, for steps without contact.
  [[nodiscard]] const LinearSolver& linear() const { return *linear_; }
  /// Null without contact.
  [[nodiscard]] const contact::ContactStepSolver* contact() const { return contact_.get(); }
  /// Whether solves start from a guess.
  [[nodiscard]] bool takes_guess() const { return iterative_ || full_; }

  /// Of a factorisation on one rank, else empty.
  [[nodiscard]] EliminationOrder order() const { return cholesky_ ? cholesky_->order() : EliminationOrder(); }

  /// Relative error that a solve may leave; 0 for rounding alone.
  [[nodiscard]] double tolerance() const { return iterative_ ? iterative_->tolerance() : 0; }

  /// What was chosen and why, in a few words.
  [[nodiscard]] const std::string& choice() const { return choice_; }

  /// Memory on all ranks, bytes.
  struct Memory {
    double factor = 0; ///< or preconditioner, with the matrix D where it is kept
    double condensation = 0;
  };
  /// Collective.
  [[nodiscard]] Memory memory() const;

private:
  void factorise(const contact::ContactPairs* pairs, const scene::Solver& scene, double solves,
                 const EliminationOrder& order);
  /// Compares prices; where the solver named `direct` is kept, `compared` says why.
  bool iterate_if_quicker(const DirectWork& work, const std::string& direct, double solves,
                          std::string& compared);
  void iterate(std::unique_ptr<ConjugateGradients> solver, const std::string& why);
  /// Condensed to the candidates, or projected, as the linear solver allows.
  [[nodiscard]] std::unique_ptr<contact::ContactStepSolver> by_linear(const contact::ContactPairs& pairs,
                                                                      const scene::Solver& scene,
                                                                      double solves,
                                                                      contact::Residual residual);

  petsc::Matrix D_; ///< null once it is factorised
  std::unique_ptr<LinearSolver> linear_;
  const SparseCholesky* cholesky_ = nullptr; ///< linear_, if it is one of these
  const MumpsSolver* mumps_ = nullptr;
  const ConjugateGradients* iterative_ = nullptr;
  bool full_ = false; ///< whether contact is solved by the VI in all unknowns
  std::unique_ptr<contact::ContactStepSolver> contact_;
  std::string choice_;
};

} // namespace signorini::step
