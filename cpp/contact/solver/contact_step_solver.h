// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/timers.h"
#include "contact/condensation.h"
#include "contact/lcp/goldfarb_idnani.h"
#include "contact/lcp/snes_vi.h"
#include <memory>
#include <optional>

namespace signorini::contact {

/// PETSc's solver of a step's inequality in the gaps g: 0 ≤ g ⟂ K (g − g⁰) ≥ 0 with the gaps g⁰ without
/// contact forces and K = S⁻¹, scaled to a mean diagonal of one.
struct CondensedVi {
  petsc::Matrix K;
  petsc::Vector x, gap0, constant;
  std::optional<SnesVi> vi;
};

/// Scratch of the solvers of contact steps, from ContactStepSolver::workspace(); each uses some of it. No
/// call depends on an earlier one, except that the factor of S_AA is reused for the same set, and so is K in
/// `condensed`: both belong to one D. Only one call at a time may use it.
struct Workspace {
  /// Reserves room for the given number of constraint rows.
  explicit Workspace(int rows) : gap0(static_cast<std::size_t>(rows)), motion(gap0.size()), mu(gap0.size()) {
    for (ActiveSet* one : {&set, &next, &wrong, &factorised, &independent})
      one->reserve(gap0.size());
    b.reserve(gap0.size());
  }

  /// Discards the data that belong to one D; required before steps with another D.
  void forget() {
    factorised.clear();
    factor.clear();
    condensed.reset();
  }

  HalfSolve half_solve;
  std::vector<double> gap0;           ///< predicted gaps of all rows, m
  ActiveSet set, next, wrong;         ///< set of an iterate, the next set, their difference
  ActiveSet factorised, independent;  ///< the set of `factor`; the independent part of a set
  std::vector<double> factor;         ///< Cholesky factor of S_AA
  std::vector<double> motion, mu;     ///< Hᵀy; multipliers of a linearised step (rows)
  std::vector<double> b;              ///< right-hand side on a set
  std::vector<LawEquation> equations; ///< equations of the set, if laws are not symmetric
  petsc::Vector residual, correction; ///< allocated when a solution is first refined
  GoldfarbIdnaniWork dual;
  std::unique_ptr<CondensedVi> condensed; ///< allocated when it is first needed
};

/// A contact step: minimise ½ y·Dy − r·y over g(y) ≥ 0 (4.22), docs/method.md section 2, that is D y + H λ =
/// r with 0 ≤ λ ⟂ g(y) ≥ 0.
struct ContactProblem {
  Vec r;
  std::span<const double> psi; ///< gaps of the undeformed body at the end of the step (rows), m
  const ActiveSet& previous;   ///< active set of the step before, from which the search starts
  ContactState& state;         ///< constructed for the m candidates
  Vec y;                       ///< the solution, a guess on entry
};

/// A linearised or transposed step on an active set (docs/method.md section 4): D x + H μ = r, Hᵀx = value
/// and free μ on the set, μ = 0 elsewhere. Among linearly dependent candidates the first ones carry the
/// force. With `equations`, on the set E (value − Hᵀx) + F μ = 0 in place of Hᵀx = value; in the transposed
/// step μ = Eᵀn and Hᵀx − Fᵀn = value.
struct LinearisedContact {
  Vec r;
  const ActiveSet& set;
  std::span<const LawEquation> equations{}; ///< equations of the set; empty if laws are symmetric
  std::span<const double> value{};          ///< right-hand sides of the rows, zero if empty
  Vec x;                                    ///< the solution, a guess on entry; not r
  std::span<double> multipliers{};          ///< μ on return (rows), not computed if empty
};

/// Solver of contact steps with one D, and of their linearised and transposed forms. Only results and `work`
/// change; PETSc's solver objects have scratch of their own, so that a solver serves one call at a time.
/// All members are collective; those that solve throw SolverFailure with reason and residual.
class ContactStepSolver {
public:
  ContactStepSolver() { ++solvers_; }
  virtual ~ContactStepSolver() = default;

  [[nodiscard]] virtual Workspace workspace() const = 0;

  virtual void solve(const ContactProblem& step, Workspace& work) const = 0;
  virtual void solve_linearised(const LinearisedContact& step, Workspace& work) const = 0;
  /// Solves the transpose of a linearised step; with symmetric laws this is the step itself.
  virtual void solve_transposed(const LinearisedContact& step, Workspace& work) const = 0;

  /// Memory beyond that of D's factor on all ranks, bytes.
  [[nodiscard]] virtual double bytes() const = 0;

protected:
  /// Counts a step whose inequality had to be solved. Solvers that test the motion without contact first do
  /// not count steps in which it does not penetrate.
  static void count_solved() { ++solved_; }

private:
  inline static long &solvers_ = count("VI solvers"), &solved_ = count("VIs solved");
};

} // namespace signorini::contact
