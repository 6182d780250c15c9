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

/// What all ranks together do in a second while all of them work.
struct MachineRates {
  double flops; ///< of dense products, on one thread of each rank
  double bytes; ///< read from an array, on all threads
};

/// Measures dense products and reads of as many bytes as `bytes` asks for on all ranks together, within
/// limits beyond which rates change no more; takes about a tenth of a second. Collective; the same on every
/// rank.
MachineRates measure_rates(MPI_Comm comm, double bytes);

/// Seconds that a way to solve the steps of a run takes.
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

  /// Whether set-up takes so little on any machine that nothing is to be gained by another way: the choice
  /// then depends on no clock.
  [[nodiscard]] bool small() const;
};

/// By rates of this machine, measured. Collective; the same on every rank.
Price price(MPI_Comm comm, const DirectWork& work);

/// Of conjugate gradients whose trial took so many seconds.
Price iterative_price(double trial);

/// Seconds that a solve by conjugate gradients may take in a trial in order to be chosen over `direct`.
double affordable(const Price& direct, double solves);

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
  /// Compares times; where the solver named `direct` is kept, `times` says why.
  bool iterate_if_quicker(const DirectWork& work, const std::string& direct, double solves,
                          std::string& times);
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
