// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/timers.h"
#include "contact/condensation.h"
#include "contact/lcp/goldfarb_idnani.h"
#include "contact/lcp/snes_vi.h"
#include <memory>
#include <optional>

namespace signorini::contact {

/// PETSc's solver for the inequality of a step in the gaps g: 0 ≤ g ⟂ K (g − g⁰) ≥ 0. g⁰ are the gaps without
/// contact forces, and K is S⁻¹ scaled to a mean diagonal entry of one.
struct CondensedVi {
  petsc::Matrix K;
  petsc::Vector x, gap0, constant;
  std::optional<SnesVi> vi;
};

/// Scratch of the solvers of contact steps, created by ContactStepSolver::workspace(); each solver uses a
/// part of it. Between calls only two matrices are kept, which belong to one D: the factor of S_AA, reused
/// for the same set, and the matrix K = S⁻¹ of PETSc's VI in `condensed`. Only one call at a time may use a
/// workspace.
struct Workspace {
  /// Reserves memory for `rows` constraint rows.
  explicit Workspace(int rows) : gap0(static_cast<std::size_t>(rows)), motion(gap0.size()), mu(gap0.size()) {
    for (ActiveSet* one : {&set, &next, &wrong, &factorised, &independent})
      one->reserve(gap0.size());
    b.reserve(gap0.size());
  }

  /// Discards the data that belong to one D. Call this before steps with another D.
  void forget() {
    factorised.clear();
    factor.clear();
    condensed.reset();
  }

  HalfSolve half_solve;
  std::vector<double> gap0;           ///< predicted gaps of all rows, m
  ActiveSet set, next, wrong;         ///< set of an iterate; next set; their difference
  ActiveSet factorised, independent;  ///< set whose factor is `factor`; linearly independent part of a set
  std::vector<double> factor;         ///< Cholesky factor of S_AA
  std::vector<double> motion, mu;     ///< Hᵀy (rows); multipliers of a linearised step (rows)
  std::vector<double> b;              ///< right-hand side on a set
  std::vector<LawEquation> equations; ///< linearised laws of the set; only if laws are not symmetric
  petsc::Vector residual, correction; ///< allocated when a solution is first refined
  GoldfarbIdnaniWork dual;
  std::unique_ptr<CondensedVi> condensed; ///< allocated when first needed
};

/// A contact step: D y + H ρ = r with the contact laws of all candidates (docs/method.md section 2). Without
/// friction: minimise ½ y·Dy − r·y subject to g(y) ≥ 0 (4.22), or D y + H λ = r with 0 ≤ λ ⟂ g(y) ≥ 0.
struct ContactProblem {
  Vec r;
  std::span<const double> psi; ///< gaps of the undeformed body at the end of the step (rows), m
  const ActiveSet& previous;   ///< active set of the previous step, from which the search starts
  ContactState& state; ///< result; constructed for the m candidates, with their coefficients of friction
  Vec y;               ///< solution; contains a guess on entry
  /// Multipliers of the previous step (rows), from which the search starts if some law is not symmetric;
  /// empty: from zero.
  std::span<const double> guess{};
};

/// A linearised or transposed step on an active set (docs/method.md section 4): D x + H μ = r, with Hᵀx =
/// value and free μ on the set, and μ = 0 elsewhere. Among linearly dependent candidates the first ones get
/// the force. If `equations` is not empty, E (value − Hᵀx) + F μ = 0 replaces Hᵀx = value in the linearised
/// step; in the transposed step μ = Eᵀn and Hᵀx − Fᵀn = value.
struct LinearisedContact {
  Vec r;
  const ActiveSet& set;
  std::span<const LawEquation> equations{}; ///< linearised laws of the set; empty if all laws are symmetric
  std::span<const double> value{};          ///< right-hand side of each row; zero if empty
  Vec x;                                    ///< solution; contains a guess on entry; must not be r
  std::span<double> multipliers{};          ///< receives μ (rows); not computed if empty
  std::span<const double> law{}; ///< with equations: c in E (value − Hᵀx) + F μ = c (rows); zero if empty
  std::span<double> law_duals{}; ///< with equations, receives n of a transposed step (rows); not if empty
};

/// Solver of contact steps with one D, and of the linearised and transposed steps. Calls change only their
/// results and `work`. A solver can serve only one call at a time, since PETSc's solver objects have scratch
/// of their own. All members are collective; those that solve throw SolverFailure with the reason and the
/// residual.
class ContactStepSolver {
public:
  ContactStepSolver() { ++solvers_; }
  virtual ~ContactStepSolver() = default;

  [[nodiscard]] virtual Workspace workspace() const = 0;

  virtual void solve(const ContactProblem& step, Workspace& work) const = 0;
  virtual void solve_linearised(const LinearisedContact& step, Workspace& work) const = 0;
  /// Solves the transposed linearised step; if all laws are symmetric, this is the linearised step itself.
  virtual void solve_transposed(const LinearisedContact& step, Workspace& work) const = 0;

  /// Solves the linearised step with one-sided laws for the weak candidates of `contact`; those on which the
  /// solution is linear replace the active set and the equations of `contact`. For laws that are not
  /// symmetric.
  virtual void solve_one_sided(const LinearisedContact& step, ContactLinearisation& contact,
                               Workspace& work) const = 0;

  /// Memory on all ranks in addition to D's factor, bytes.
  [[nodiscard]] virtual double bytes() const = 0;

protected:
  /// Counts a step whose inequality had to be solved. Solvers that first test the motion without contact
  /// forces do not count steps in which this motion does not penetrate.
  static void count_solved() { ++solved_; }

private:
  inline static long &solvers_ = count("VI solvers"), &solved_ = count("VIs solved");
};

} // namespace signorini::contact
