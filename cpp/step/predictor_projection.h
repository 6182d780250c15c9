// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include "fem/operators.h"
#include "step/solver_choice.h"

namespace signorini::step {

/// The projection that contact-stabilized stepping (docs/method.md section 2) adds to a step: the predictor x
/// = y_{k−1} + τ v_{k−1} is moved to z, the nearest point to it in the norm of M that obeys the contact
/// condition. z − x is called the jump. For a predictor that obeys it already only the gaps are computed.
class PredictorProjection {
public:
  /// Factorises M, which is also given in `blocks` (BAIJ). `derivatives`: linearised or transposed steps are
  /// needed; `solves` as in SolverChoice. Collective. The references must outlive this object. Throws
  /// SolverFailure.
  PredictorProjection(petsc::Matrix blocks, Mat M, const fem::DirichletDofs& clamped,
                      const contact::ContactPairs& pairs, const scene::Solver& scene, bool derivatives,
                      double solves);

  /// Storage of jumps.
  struct Workspace {
    petsc::Vector r, jump;
    std::vector<double> gap;       ///< (m)
    contact::ContactState contact; ///< contact state of the projection
    contact::Workspace solver;
  };
  /// Collective.
  [[nodiscard]] Workspace workspace() const;

  /// The jump z − x of the predictor x for the gaps ψ of the undeformed body (m, in metres), null if it is
  /// zero, in `work`; `set` becomes Z, the candidates that z touches, and `previous` is the Z of the step
  /// before, from which the search starts. Collective. Throws SolverFailure.
  [[nodiscard]] Vec jump(std::span<const double> psi, Vec x, const contact::ActiveSet& previous,
                         contact::ActiveSet& set, Workspace& work) const;

  /// Πx − x with Π the projection linearised on the set Z, null where Z is empty, in `work`. Π is
  /// self-adjoint in the product of M. With `data`, z − x for the solution of M z + H ζ = M x + force with
  /// Hᵀz = motion (m) on Z. Collective.
  struct Data {
    Vec force = nullptr;            ///< a functional; null: zero
    std::span<const double> motion; ///< m
    std::span<double> multipliers;  ///< ζ on return (m)
  };
  [[nodiscard]] Vec linearised_jump(const contact::ActiveSet& set, Vec x, Workspace& work,
                                    const Data* data = nullptr) const;

  /// Memory on all ranks, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  Mat M_;
  const fem::DirichletDofs& clamped_;
  const contact::ContactPairs& pairs_;
  SolverChoice solver_;
  petsc::Vector zero_;
};

} // namespace signorini::step
