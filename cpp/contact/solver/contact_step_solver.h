// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/timers.h"
#include "contact/condensation.h"
#include "contact/lcp/goldfarb_idnani.h"
#include "contact/lcp/snes_vi.h"
#include <memory>
#include <optional>

namespace signorini::contact {

/// PETSc's VI solver of a condensed step: 0 ≤ g ⟂ K (g − g⁰) ≥ 0 with K = S⁻¹, scaled to a mean diagonal of
/// one.
struct CondensedVi {
  petsc::Matrix K;
  petsc::Vector x, gap0, constant;
  std::optional<SnesVi> vi;
};

/// Scratch of the solvers of contact steps, made by ContactStepSolver::workspace(); each uses some of it. No
/// call depends on what an earlier one left, except that the factor of S_AA is used again for the same set,
/// and K in `condensed`: both belong to one D. One at a time may work with it.
struct Workspace {
  /// For so many rows of constraints.
  explicit Workspace(int rows) : gap0(static_cast<std::size_t>(rows)), motion(gap0.size()), mu(gap0.size()) {
    for (ActiveSet* one : {&set, &next, &wrong, &factorised, &independent})
      one->reserve(gap0.size());
    b.reserve(gap0.size());
  }

  /// To be called before steps with another D.
  void forget() {
    factorised.clear();
    factor.clear();
    condensed.reset();
  }

  HalfSolve half_solve;
  std::vector<double> gap0;           ///< predicted gaps (m), of rows as those below
  ActiveSet set, next, wrong;         ///< that of an iterate, the one after it, where they differ
  ActiveSet factorised, independent;  ///< the set of `factor`; the independent part of a set
  std::vector<double> factor;         ///< Cholesky factor of S_AA
  std::vector<double> motion, mu;     ///< Hᵀy; multipliers of a linearised step
  std::vector<double> b;              ///< right-hand side on a set
  std::vector<LawEquation> equations; ///< of the set, where laws are not symmetric
  petsc::Vector residual, correction; ///< made when a solution is first refined
  GoldfarbIdnaniWork dual;
  std::unique_ptr<CondensedVi> condensed; ///< made when it is first needed
};

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
  ContactStepSolver() { ++solvers_; }
  virtual ~ContactStepSolver() = default;

  [[nodiscard]] virtual Workspace workspace() const = 0;

  virtual void solve(const ContactProblem& step, Workspace& work) const = 0;
  virtual void solve_linearised(const LinearisedContact& step, Workspace& work) const = 0;
  /// The transpose of a linearised step, which with symmetric laws is that step itself.
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
