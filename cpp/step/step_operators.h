// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/moving_clamps.h"
#include "step/solver_choice.h"
#include "step/time_grid.h"
#include <functional>
#include <list>

namespace signorini::step {

/// What a step needs that depends on its length alone: R and a solver with D, one for each length that
/// occurs, made when it first does. Where those of all lengths would exceed the memory that the scene allows,
/// the ones unused for longest are made again when they are needed. The way of solving is chosen for the
/// first length, and all others follow: their D has the same entries, and shorter steps are the easier ones.
class StepOperators {
public:
  struct PerStepLength {
    double tau; ///< s
    petsc::Matrix R{};
    petsc::Matrix whole_D{};     ///< before clamped dofs were decoupled; null where no clamp moves
    double clamped_diagonal = 0; ///< of D on the clamped dofs
    std::unique_ptr<const SolverChoice> solver{};
    double bytes = 0;
  };

  /// Makes D of a length, in blocks. Collective.
  using Assemble = std::function<petsc::Matrix(double tau)>;

  /// `solves`: expected with one length, as of SolverChoice; `whole`: clamps move. The references must
  /// outlive this object.
  StepOperators(const fem::Space& space, Mat A, const fem::DirichletDofs& clamped,
                const contact::ContactPairs* pairs, const scene::Solver& solver, bool derivatives,
                double solves, bool whole, Assemble assemble);

  /// Those of a length; valid until the next call. Collective. Throws SolverFailure.
  const PerStepLength& at(double tau) const;
  /// Those returned last; at() must have been called before.
  [[nodiscard]] const PerStepLength& latest() const { return lengths_.front(); }

  /// Number of lengths that were factorised, each time counted, and how long that took, s.
  [[nodiscard]] int made() const { return made_; }
  [[nodiscard]] double seconds() const { return seconds_; }

private:
  [[nodiscard]] PerStepLength make(double tau) const;
  /// Of D, by products with R and A.
  [[nodiscard]] contact::Residual residual(double tau, Mat R) const;

  const fem::Space& space_;
  Mat A_;
  const fem::DirichletDofs& clamped_;
  const contact::ContactPairs* pairs_;
  mutable scene::Solver scene_; ///< once the first length is known, with the way of solving chosen for it
  bool derivatives_;
  double solves_;
  bool whole_;
  Assemble assemble_;
  mutable EliminationOrder order_;           ///< likewise
  mutable std::list<PerStepLength> lengths_; ///< the one used last in front
  mutable int made_ = 0;
  mutable double seconds_ = 0;
};

} // namespace signorini::step
