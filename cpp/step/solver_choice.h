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

/// Estimated time of a solver for the steps of a run, in seconds on a machine of fixed rates. So the choice
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
  /// elimination order, else 0; then the columns of D⁻¹N are solved for.
  DirectWork(const FactorWork& factor, double candidates, double trailing_block);

  /// Whether set-up takes too little time for another solver to be worthwhile.
  [[nodiscard]] bool small() const;
};

/// Price of a factorisation by CHOLMOD, on one rank, or by MUMPS.
Price price(const DirectWork& work, int ranks);

/// Price of conjugate gradients with iterations of `iteration_bytes`, whose trial took `trial_work`
/// (ConjugateGradients::trial_work()).
Price iterative_price(double trial_work, double iteration_bytes, int ranks);

/// Largest work of a trial at which conjugate gradients are chosen over `direct`.
double affordable(const Price& direct, double solves, double iteration_bytes, int ranks);

/// Lower estimate of a factor's bytes on one rank, without an analysis: by the layers of the matrix graph
/// around a node as far out as possible; 0 where the graph is not known. Not collective.
double least_factor_bytes(Mat D);

/// The solvers of a run's steps, as the scene's [solver] says: a factorisation (CHOLMOD on one rank, MUMPS on
/// several) with contact condensed to the candidates, or conjugate gradients where the factor would not fit
/// the memory allowed or would take clearly longer.
class SolverChoice {
public:
  /// Estimates the factor's memory and time, chooses a solver and factorises. `pairs` is null without
  /// contact; `derivatives`: linearised or transposed steps are needed; `solves`: expected number, to compare
  /// times, 0 to choose by memory alone. `order`: the elimination order of a matrix with the same entries, if
  /// one is known. `residual`: that of D for CondensedSolver, since a factorised D is not kept. Collective,
  /// with the same choice on every rank. The references must outlive this object. Throws
  /// SolverFailure.
  SolverChoice(petsc::Matrix D, const contact::ContactPairs* pairs, const scene::Solver& scene,
               bool derivatives, double solves = 0, const EliminationOrder& order = {},
               contact::Residual residual = {});

  /// Whether D is not factorised.
  [[nodiscard]] bool iterates() const { return iterative_ != nullptr; }
  /// Solves with D, for steps without contact.
  [[nodiscard]] const LinearSolver& linear() const { return *linear_; }
  /// The contact solver; null without contact.
  [[nodiscard]] const contact::ContactStepSolver* contact() const { return contact_.get(); }
  /// Whether solves start from a guess.
  [[nodiscard]] bool takes_guess() const { return iterative_ || full_; }

  /// Elimination order of a factorisation on one rank, else empty.
  [[nodiscard]] EliminationOrder order() const { return cholesky_ ? cholesky_->order() : EliminationOrder(); }

  /// Relative error that a solve may leave; 0 for a direct solver, which leaves rounding alone.
  [[nodiscard]] double tolerance() const { return iterative_ ? iterative_->tolerance() : 0; }

  /// The chosen solver and the reason, in a few words.
  [[nodiscard]] const std::string& choice() const { return choice_; }

  /// Memory on all ranks, bytes.
  struct Memory {
    double factor = 0; ///< factor or preconditioner, and D where it is kept
    double condensation = 0;
  };
  /// Collective.
  [[nodiscard]] Memory memory() const;

private:
  void factorise(const contact::ContactPairs* pairs, const scene::Solver& scene, double solves,
                 const EliminationOrder& order);
  /// Compares costs and takes conjugate gradients where they are cheaper, and returns whether; else sets
  /// `compared` to the reason why the solver named `direct` stays.
  bool iterate_if_quicker(const DirectWork& work, const std::string& direct, double solves,
                          std::string& compared);
  void iterate(std::unique_ptr<ConjugateGradients> solver, const std::string& why);
  /// Makes the contact solver: condensed to the candidates or projected, as the linear solver allows.
  [[nodiscard]] std::unique_ptr<contact::ContactStepSolver> by_linear(const contact::ContactPairs& pairs,
                                                                      const scene::Solver& scene,
                                                                      double solves,
                                                                      contact::Residual residual);

  petsc::Matrix D_; ///< null once it is factorised
  std::unique_ptr<LinearSolver> linear_;
  const SparseCholesky* cholesky_ = nullptr; ///< linear_, if it has this type
  const MumpsSolver* mumps_ = nullptr;
  const ConjugateGradients* iterative_ = nullptr;
  bool full_ = false; ///< whether contact is solved by the VI in all unknowns
  std::unique_ptr<contact::ContactStepSolver> contact_;
  std::string choice_;
};

} // namespace signorini::step
