// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/workspace.h"

namespace signorini::contact {

/// A contact step: minimise ½ y·Dy − r·y over g(y) ≥ 0 (4.22), docs/method.md section 2, that is D y + H λ =
/// r with 0 ≤ λ ⟂ g(y) ≥ 0.
struct ContactProblem {
  Vec r;
  std::span<const double> psi; ///< gaps of the undeformed body at the end of the step, of rows, in metres
  const ActiveSet& previous;   ///< of the step before, from which the search starts
  ContactState& state;         ///< constructed for the m candidates
  Vec y;                       ///< the solution, a guess on entry
};

/// A linearised or transposed step on an active set (docs/method.md section 4): D x + H μ = r, Hᵀx = value
/// and free μ on the set, μ = 0 elsewhere. Of linearly dependent candidates the first ones carry the force.
/// With `equations`, on the set E (value − Hᵀx) + F μ = 0 in place of Hᵀx = value; transposed μ = Eᵀn and
/// Hᵀx − Fᵀn = value.
struct LinearisedContact {
  Vec r;
  const ActiveSet& set;
  std::span<const LawEquation> equations{}; ///< of the set; empty if laws are symmetric
  std::span<const double> value{};          ///< of rows, zero if empty
  Vec x;                                    ///< the solution, a guess on entry; not r
  std::span<double> multipliers{};          ///< μ of rows on return, not computed if empty
};

/// Solver of contact steps with one D, and of their linearised and transposed forms. Only results and `work`
/// change; PETSc's solver objects hold scratch of their own, so that one solver serves one call at a time.
/// All members are collective; those that solve throw SolverFailure with reason and residual.
class ContactStepSolver {
public:
  ContactStepSolver();
  virtual ~ContactStepSolver() = default;

  [[nodiscard]] virtual Workspace workspace() const = 0;

  void solve(std::span<const ContactProblem> steps, Workspace& work) const {
    for (const ContactProblem& one : steps)
      solve_one(one, work);
  }
  void solve_linearised(std::span<const LinearisedContact> steps, Workspace& work) const {
    for (const LinearisedContact& one : steps)
      solve_one(one, false, work);
  }
  /// The transposes of linearised steps, which with symmetric laws are these themselves.
  void solve_transposed(std::span<const LinearisedContact> steps, Workspace& work) const {
    for (const LinearisedContact& one : steps)
      solve_one(one, true, work);
  }

  /// Memory beyond that of D's factor on all ranks, bytes.
  [[nodiscard]] virtual double bytes() const = 0;

protected:
  virtual void solve_one(const ContactProblem& step, Workspace& work) const = 0;
  virtual void solve_one(const LinearisedContact& step, bool transposed, Workspace& work) const = 0;

  /// Counts a step whose inequality had to be solved. Solvers that test the motion without contact first do
  /// not count steps in which it does not penetrate.
  static void count_solved();
};

} // namespace signorini::contact
