// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/moving_clamps.h"
#include "step/solver_choice.h"
#include "step/time_grid.h"
#include <functional>
#include <list>

namespace signorini::step {

/// Operators that depend only on the length of a step: the matrix R and a solver for D (docs/method.md,
/// section 1), made when a length first occurs. Where all lengths together would exceed the memory that the
/// scene allows, the least recently used ones are discarded and recomputed when needed. The kind of solver is
/// chosen for the first length and serves for all, since their D have the same sparsity.
class StepOperators {
public:
  struct PerStepLength {
    double tau; ///< s
    petsc::Matrix R{};
    petsc::Matrix whole_D{};     ///< D before clamped dofs were decoupled; null where no clamp moves
    double clamped_diagonal = 0; ///< entry of D on the clamped dofs
    std::unique_ptr<const SolverChoice> solver{};
    double bytes = 0;
  };

  /// Makes D of a length, in blocks. Collective.
  using Assemble = std::function<petsc::Matrix(double tau)>;

  /// `solves`: expected number with one length, as in SolverChoice; `whole`: clamps move. The references must
  /// outlive this object.
  StepOperators(const fem::Space& space, Mat A, const fem::DirichletDofs& clamped,
                const contact::ContactPairs* pairs, const scene::Solver& solver, bool derivatives,
                double solves, bool whole, Assemble assemble);

  /// Operators of a length; valid until the next call. Collective. Throws SolverFailure.
  const PerStepLength& at(double tau) const;
  /// Operators returned last; at() must have been called before.
  [[nodiscard]] const PerStepLength& latest() const { return lengths_.front(); }

  /// Number of factorisations so far, repeated ones included, and their total time, s.
  [[nodiscard]] int made() const { return made_; }
  [[nodiscard]] double seconds() const { return seconds_; }

private:
  [[nodiscard]] PerStepLength make(double tau) const;
  /// The residual r − D y on the free dofs, by products with R and A.
  [[nodiscard]] contact::Residual residual(double tau, Mat R) const;

  const fem::Space& space_;
  Mat A_;
  const fem::DirichletDofs& clamped_;
  const contact::ContactPairs* pairs_;
  mutable scene::Solver scene_; ///< with the linear solver chosen for the first length, once known
  bool derivatives_;
  double solves_;
  bool whole_;
  Assemble assemble_;
  mutable EliminationOrder order_;           ///< elimination order of the first length, once known
  mutable std::list<PerStepLength> lengths_; ///< the last used one first
  mutable int made_ = 0;
  mutable double seconds_ = 0;
};

} // namespace signorini::step
