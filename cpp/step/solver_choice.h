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

/// Estimated times of a solver in the steps of a run, s. Speeds of computing and of memory are constants of
/// the program, so that the choice of a solver is the same on every machine and under any load.
struct Price {
  double setup = 0, solve = 0; ///< times of the set-up and of one solve, s
  [[nodiscard]] double total(double solves) const { return setup + solves * solve; }
};

/// Work of a direct solver and of its contact solver.
struct DirectWork {
  double setup_flops = 0;
  double solve_bytes = 0; ///< bytes that a solve reads

  /// Estimates the work from that of the factor. `candidates`: number m of contact candidates.
  /// `trailing_block`: number of unknowns at the candidates' nodes if these come last in the elimination
  /// order. Otherwise it is 0, and condensation solves for m columns of D⁻¹N.
  DirectWork(const FactorWork& factor, double candidates, double trailing_block);

  /// Returns whether the set-up is so short (below 2e9 operations) that no other solver is worthwhile.
  [[nodiscard]] bool small() const;
};

/// Returns the price of a direct solver: CHOLMOD on one rank, MUMPS on several.
Price price(const DirectWork& work, int ranks);

/// Estimates the price of MUMPS from the numbers of unknowns and entries of D, before MUMPS analyses D.
/// Collective.
Price expected_mumps_price(Mat D, int ranks);

/// Returns the price of conjugate gradients. `trial_work`: ConjugateGradients::trial_work(), a number of
/// iterations; `iteration_bytes`: memory traffic of one iteration, bytes.
Price iterative_price(double trial_work, double iteration_bytes, int ranks);

/// Returns the largest trial_work (iterations, see iterative_price()) at which conjugate gradients are chosen
/// over a direct solver of price `direct`, for `solves` solves.
double affordable(const Price& direct, double solves, double iteration_bytes, int ranks);

/// Returns a lower estimate of a factor's memory on one rank, bytes, without a symbolic analysis. The
/// estimate follows from the mean size of layers of the matrix graph, sets of nodes at equal distance from a
/// node at the rim. Returns 0 if PETSc does not provide the graph. Not collective.
double least_factor_bytes(Mat D);

/// Solvers for the steps of a run, chosen as the scene's [solver] says. The choice is between a factorisation
/// (CHOLMOD on one rank, MUMPS on several) with contact condensed to the candidates, and conjugate gradients.
/// If the choice is automatic, conjugate gradients are taken if the factor would exceed the memory limit or
/// take clearly longer.
class SolverChoice {
public:
  /// Estimates the factor's memory and time, chooses a solver and factorises. `pairs`: null without contact.
  /// `derivatives`: whether linearised or transposed steps are needed. `solves`: expected number of solves,
  /// for comparing times; 0: memory alone decides. `order`: elimination order of a matrix with the same
  /// sparsity, if available. `residual`: computes r − D y for CondensedSolver, since a factorised D is not
  /// stored. Collective; every rank makes the same choice. The references must outlive this object. Throws
  /// SolverFailure.
  SolverChoice(petsc::Matrix D, const contact::ContactPairs* pairs, const scene::Solver& scene,
               bool derivatives, double solves = 0, const EliminationOrder& order = {},
               contact::Residual residual = {});
  /// Shares the factorisation of `like`, whose D is the same, and its contact solver if `same_rows`: if the
  /// rows of `pairs` equal those of `like`. like.shares() must be true. Collective.
  SolverChoice(const SolverChoice& like, const contact::ContactPairs* pairs, bool same_rows,
               const scene::Solver& scene, contact::Residual residual);
  /// Returns whether other solvers may share this one's factorisation: it is direct, and contact is
  /// condensed.
  [[nodiscard]] bool shares() const { return !iterative_ && !full_; }

  /// Returns whether the solver is iterative, so that D is not factorised.
  [[nodiscard]] bool iterates() const { return iterative_ != nullptr; }
  /// Returns the solver for D, for steps without contact.
  [[nodiscard]] const LinearSolver& linear() const { return *linear_; }
  /// Returns the contact solver; null without contact.
  [[nodiscard]] const contact::ContactStepSolver* contact() const { return contact_.get(); }
  /// Returns whether solves use a guess of the solution.
  [[nodiscard]] bool takes_guess() const { return iterative_ || full_; }

  /// Makes the solves of the tasks of `lockstep` together, by CHOLMOD; null: no more. Returns whether it
  /// does.
  bool unite(Lockstep* lockstep) const {
    if (cholesky_)
      cholesky_->unite(lockstep);
    return cholesky_ != nullptr;
  }
  /// Returns the elimination order of a factorisation by CHOLMOD; empty for other solvers.
  [[nodiscard]] EliminationOrder order() const { return cholesky_ ? cholesky_->order() : EliminationOrder(); }

  /// Returns the relative tolerance of a solve (ConjugateGradients::tolerance()); 0 for a direct solver,
  /// whose only error is rounding.
  [[nodiscard]] double tolerance() const { return iterative_ ? iterative_->tolerance() : 0; }

  /// Returns the name of the chosen solver and the reason for the choice, as text.
  [[nodiscard]] const std::string& choice() const { return choice_; }

  /// Memory of the solvers on all ranks, bytes.
  struct Memory {
    double factor = 0;       ///< factor or preconditioner, and D if it is stored
    double condensation = 0; ///< contact solver
  };
  /// Returns the memory of the solvers. Collective.
  [[nodiscard]] Memory memory() const;

private:
  void factorise(const contact::ContactPairs* pairs, const scene::Solver& scene, double solves,
                 const EliminationOrder& order);
  /// Chooses conjugate gradients and returns true if they are estimated to be faster than the solver named
  /// `direct`, whose price is `factor`. Otherwise returns false and sets `compared` to a text that compares
  /// the times. Leaves `compared` unchanged if there is no preconditioner.
  bool iterate_if_quicker(const Price& factor, const std::string& direct, double solves,
                          std::string& compared);
  void iterate(std::unique_ptr<ConjugateGradients> solver, const std::string& why);
  /// Creates the contact solver for the chosen linear solver. With a factorisation, contact is condensed to
  /// the candidates. With conjugate gradients, iterations are projected onto the active set, or contact is
  /// condensed with columns of D⁻¹N that are computed on demand.
  [[nodiscard]] std::unique_ptr<contact::ContactStepSolver> by_linear(const contact::ContactPairs& pairs,
                                                                      const scene::Solver& scene,
                                                                      double solves,
                                                                      contact::Residual residual);

  petsc::Matrix D_; ///< null after a factorisation
  std::shared_ptr<const LinearSolver> linear_;
  const SparseCholesky* cholesky_ = nullptr; ///< linear_ if it has this type, else null
  const MumpsSolver* mumps_ = nullptr;
  const ConjugateGradients* iterative_ = nullptr;
  bool full_ = false; ///< whether contact is solved as one inequality in all unknowns (solver.vi)
  std::shared_ptr<const petsc::Vector> diagonal_; ///< of a factorised D, with contact; else null
  std::shared_ptr<const contact::ContactStepSolver> contact_;
  std::string choice_;
};

} // namespace signorini::step
