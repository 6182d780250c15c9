#pragma once
#include "contact/delassus_operator.h"
#include "contact/linear_vi.h"
#include "contact/vi_solver.h"
#include <memory>

namespace signorini::contact {

/// Solves the step's VI condensed to the m candidates (docs/method.md section 5): with the predicted gaps g⁰
/// = g(D⁻¹r), 0 ≤ λ ⟂ g = g⁰ + Sλ ≥ 0 and y = D⁻¹(r − Nλ). No VI is solved if no predicted gap is negative.
/// Otherwise the active set is sought by primal-dual steps from that of the previous step, from which it
/// mostly differs in few candidates. Where these do not settle soon, PETSc's VI solver finds the set from the
/// VI in the gaps, 0 ≤ g ⟂ S⁻¹(g − g⁰) ≥ 0: S⁻¹, unlike S, is close to an M-matrix, for which reduced-space
/// Newton does not cycle. A dual active-set method replaces PETSc's solver where candidates are linearly
/// dependent, so that S is singular, and is the last resort where both others fail. Active sets that depend
/// on LAPACK's rounding are determined on rank 0.
class CondensedVi final : public ViSolver {
public:
  /// The arguments must outlive this object. PETSc options with the prefix `-condensed_vi_` are honoured.
  CondensedVi(const Constraints& constraints, const DelassusOperator& condensation,
              const Complementarity& complementarity);

  void solve(Vec r, std::span<const double> psi, const ContactSets& previous, ContactState& state,
             Vec y) const override;

private:
  /// PETSc's VI solver of the condensed problem, made when it is first needed.
  struct Petsc {
    petsc::Matrix K; ///< S⁻¹ scaled to a mean diagonal entry of one
    petsc::Vector x, gap0, constant;
    std::unique_ptr<LinearVi> vi;
  };

  /// Computes λ, with zero gaps on set_ and zero forces elsewhere, and the gaps g⁰ + Sλ of all candidates.
  void solve_on_set(ContactState& state) const;
  /// At most `most` primal-dual steps, until the state is complementary to rounding and within the gap
  /// `negligible` (m).
  void settle(ContactState& state, std::span<const double> psi, double negligible, int most) const;
  /// Whether the state is complementary to rounding of the step's own motion.
  [[nodiscard]] bool holds(const ContactState& state, std::span<const double> psi) const;
  /// The deepest predicted penetration, m.
  [[nodiscard]] double deepest() const;
  /// Finds set_ by PETSc's VI solver, starting from the gaps of `state`; if it fails, set_ becomes the
  /// candidates with negative predicted gaps.
  void find_set(ContactState& state) const;
  /// Finds set_ by the dual active-set method, from no contact, which terminates for every S. Throws
  /// SolverFailure if the gaps cannot all be made nonnegative.
  void find_independent_set(ContactState& state) const;
  /// Finds set_ by find_set() where S is regular and of a size that PETSc can handle, else by
  /// find_independent_set().
  void search(ContactState& state) const;
  /// Broadcasts the set, λ and number of steps that rank 0 found. Collective.
  void decided(ContactState& state) const;
  const Petsc& petsc() const;

  const Constraints& constraints_;
  const DelassusOperator& condensation_;
  const Complementarity& complementarity_;
  double length_unit_; ///< of gaps in PETSc's VI: a negligible gap, m
  mutable std::vector<double> gap0_, forces_;
  mutable ActiveSet set_, next_;
  mutable DualActiveSet dual_;
  mutable std::unique_ptr<Petsc> petsc_;
};

} // namespace signorini::contact
