// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/workspace.h"

namespace signorini::contact {

/// Solver of contact steps and of their linearised and transposed forms. Only `state` or `p`, `y` and `work`
/// change; PETSc's solver objects hold scratch of their own, so that one solver serves one step at a time.
/// All members collective.
class ContactStepSolver {
public:
  ContactStepSolver();
  virtual ~ContactStepSolver() = default;

  [[nodiscard]] virtual Workspace workspace() const = 0;

  /// A step: minimise ½ y·Dy − r·y over g(y) ≥ 0 (4.22), docs/method.md section 2. Solves for `y`, which
  /// holds a guess on entry, and for `state`, constructed for the m candidates; `psi` (m) are the gaps of the
  /// undeformed body at the end of the step, in metres, `previous` is the active set of the step before, from
  /// which the search starts. Throws SolverFailure with reason and residual.
  virtual void solve(Vec r, std::span<const double> psi, const ActiveSet& previous, ContactState& state,
                     Vec y, Workspace& work) const = 0;

  /// A linearised or transposed step on an active set (docs/method.md section 4): D p − μ = r, p·ν = 0 on the
  /// set and normal forces μ there. The solution operator r ↦ p is symmetric. Solves for `p`, which holds a
  /// guess on entry that direct solvers ignore; `r` and `p` must be different vectors. Of linearly dependent
  /// candidates the first ones carry the force. Throws SolverFailure.
  void solve_sliding(Vec r, const ActiveSet& set, Vec p, Workspace& work) const {
    solve_guided(r, set, {}, p, work);
  }

  /// The same with p·ν = `value` (m) on the set, zero if empty: D p + N μ = r. On return work.mu (m) holds
  /// the forces μ, zero off the set; with conjugate gradients only if `value` is given. Collective. Throws
  /// SolverFailure.
  virtual void solve_guided(Vec r, const ActiveSet& set, std::span<const double> value, Vec p,
                            Workspace& work) const = 0;

  /// Memory beyond that of D's factor on all ranks, bytes.
  [[nodiscard]] virtual double bytes() const = 0;

protected:
  /// Counts a step whose inequality had to be solved. Solvers that test the motion without contact first do
  /// not count steps in which it does not penetrate.
  static void count_solved();
};

} // namespace signorini::contact
