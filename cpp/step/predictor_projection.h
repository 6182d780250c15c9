// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include "fem/operators.h"
#include "step/solver_choice.h"

namespace signorini::step {

/// Projection of the predictor x = y_{k−1} + τ v_{k−1} in contact-stabilized steps (docs/method.md section
/// 2). It moves x to z, the point nearest to x in the norm of M that satisfies the contact condition; z − x
/// is called the jump. If x satisfies the condition already, only gaps are computed.
class PredictorProjection {
public:
  /// Factorises the mass matrix, which is passed twice: `M` for products, `blocks` (BAIJ) for the solver.
  /// `derivatives`: whether linearised or transposed steps are needed; `solves`: as in SolverChoice.
  /// Collective. The references must outlive this object. Throws SolverFailure.
  PredictorProjection(petsc::Matrix blocks, Mat M, const fem::DirichletDofs& clamped,
                      const contact::ContactPairs& pairs, const scene::Solver& scene, bool derivatives,
                      double solves);

  /// Shares the factorisation of `like`, and its contact solver if `same_rows`, as SolverChoice does.
  PredictorProjection(const PredictorProjection& like, Mat M, const fem::DirichletDofs& clamped,
                      const contact::ContactPairs& pairs, bool same_rows, const scene::Solver& scene);

  /// Returns whether other projections may share the factorisation.
  [[nodiscard]] bool shares() const { return solver_.shares(); }

  /// Scratch and results of jump() and linearised_jump().
  struct Workspace {
    petsc::Vector r, jump;
    std::vector<double> gap;        ///< gaps of the predictor, m
    std::vector<double> gap_before; ///< gaps at the begin of the step, m; set where a predictor touches
    contact::ContactState contact;  ///< contact state of the projection
    contact::Workspace solver;
  };
  /// Creates scratch for jump() and linearised_jump(). Collective.
  [[nodiscard]] Workspace workspace() const;

  /// Projects the predictor `x` and returns its jump z − x, which is stored in `work`; null if the jump is
  /// zero. `psi`: gaps of the undeformed body (rows), m. `set` becomes Z, the candidates that z touches.
  /// `previous`: Z of the previous step, from which the search for Z starts. Collective. Throws
  /// SolverFailure.
  [[nodiscard]] Vec jump(std::span<const double> psi, Vec x, const contact::ActiveSet& previous,
                         contact::ActiveSet& set, Workspace& work) const;

  /// Completes Z and the weak part of Z after the step, whose contact is `contact`. A candidate that touches
  /// at x is in Z, though jump() moves no candidate within the tolerance of gaps, if it is in W, so that
  /// projection and step have their kink together, or if it was open at the begin of the step. `projected`:
  /// whether there was a jump; `psi`: gaps at y = 0, m; `before`: displacement at the begin of the step, m;
  /// `previous`: contact of the step before. Collective.
  void find_weak(contact::ContactState& contact, bool projected, std::span<const double> psi, Vec before,
                 const contact::ContactLinearisation& previous, Workspace& work) const;

  /// Projects as linearised_jump() on Z, but the candidates `weak` may open: z minimises ½ (z − x)·M(z − x)
  /// over Hᵀz ≤ 0 on them. On return `set` are those that stay closed. Collective. Throws SolverFailure.
  [[nodiscard]] Vec one_sided_jump(contact::ActiveSet& set, const contact::ActiveSet& weak, Vec x,
                                   Workspace& work) const;

  /// Data of an inhomogeneous linearised_jump(): z solves M z + H ζ = M x + force, Hᵀz = normal on the set Z.
  struct Data {
    Vec force = nullptr;            ///< a functional on V; null: zero
    std::span<const double> normal; ///< prescribed Hᵀz (rows), m
    std::span<double> multipliers;  ///< ζ on return (rows)
  };
  /// Returns the jump Πx − x, where Π is the projection linearised on the set Z = `set`; null if Z is empty.
  /// The jump is stored in `work`. Π is self-adjoint in the product of M. With `data`, returns z − x for the
  /// inhomogeneous problem of Data. Collective.
  [[nodiscard]] Vec linearised_jump(const contact::ActiveSet& set, Vec x, Workspace& work,
                                    const Data* data = nullptr) const;

  /// Makes the solves of the tasks of `lockstep` together, as SolverChoice::unite() does; null: no more.
  void unite(Lockstep* lockstep) const { (void)solver_.unite(lockstep); }

  /// Returns the memory of factor and condensation on all ranks, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  Mat M_;
  const fem::DirichletDofs& clamped_;
  const contact::ContactPairs& pairs_;
  SolverChoice solver_;
  petsc::Vector zero_;
};

} // namespace signorini::step
