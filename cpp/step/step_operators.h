// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/moving_clamps.h"
#include "step/solver_choice.h"
#include "step/time_grid.h"
#include <functional>
#include <list>

namespace signorini::step {

/// Operators that depend only on the step length, created when a length first occurs: the matrix R and a
/// solver for D (docs/method.md section 1). If the operators of all lengths exceed the scene's memory limit,
/// the least recently used ones are discarded, and recomputed when needed. The kind of solver is chosen for
/// the first length and used for all, since D always has the same sparsity.
class StepOperators {
public:
  /// Operators and solver of one step length.
  struct PerStepLength {
    double tau; ///< step length, s
    std::shared_ptr<const petsc::Matrix> shared_R{};
    std::shared_ptr<const petsc::Matrix> shared_whole_D{}; ///< null if no clamp moves
    double clamped_diagonal = 0; ///< diagonal entry of the decoupled D on clamped dofs
    std::unique_ptr<const SolverChoice> solver{};
    double bytes = 0; ///< memory of solver and R on all ranks, bytes

    [[nodiscard]] Mat R() const { return *shared_R; }
    /// Returns D before its clamped dofs were decoupled; only if clamps move.
    [[nodiscard]] Mat whole_D() const { return *shared_whole_D; }
  };

  /// Function that assembles D for the step length `tau` (s), as a matrix in blocks. Collective.
  using Assemble = std::function<petsc::Matrix(double tau)>;

  /// `solves`: expected number of solves with one length, as in SolverChoice; `whole`: whether clamps move,
  /// which requires whole_D. `like`: operators of the same body, whose matrices and factorisations are used;
  /// `same_rows`: as in SolverChoice. The references must outlive this object.
  StepOperators(const fem::Space& space, Mat A, const fem::DirichletDofs& clamped,
                const contact::ContactPairs* pairs, const scene::Solver& solver, bool derivatives,
                double solves, bool whole, Assemble assemble, const StepOperators* like = nullptr,
                bool same_rows = false);

  /// Returns the operators of step length `tau` (s), factorised if necessary; valid until the next call.
  /// Collective. Throws SolverFailure.
  const PerStepLength& at(double tau) const;
  /// Returns the operators that at() returned last; at() must have been called before.
  [[nodiscard]] const PerStepLength& latest() const { return lengths_.front(); }

  /// Number of factorisations so far, repeated ones included.
  [[nodiscard]] int factorisations() const { return factorisations_; }
  /// Total time of the factorisations so far, s.
  [[nodiscard]] double factorisation_seconds() const { return factorisation_seconds_; }

private:
  [[nodiscard]] PerStepLength make(double tau) const;
  /// Returns a function that computes the residual r − D y on the free dofs by products with R and A.
  [[nodiscard]] contact::Residual residual(double tau, Mat R) const;

  const fem::Space& space_;
  Mat A_;
  const fem::DirichletDofs& clamped_;
  const contact::ContactPairs* pairs_;
  mutable scene::Solver scene_; ///< the scene's [solver], with the kind of solver chosen for the first length
  bool derivatives_;
  double solves_;
  bool whole_;
  Assemble assemble_;
  const StepOperators* like_;
  bool same_rows_;
  mutable EliminationOrder order_;           ///< elimination order of the first length; empty before
  mutable std::list<PerStepLength> lengths_; ///< most recently used first
  mutable int factorisations_ = 0;
  mutable double factorisation_seconds_ = 0;
};

} // namespace signorini::step
