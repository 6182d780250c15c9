#pragma once
#include "contact/condensation.h"
#include "contact/linear_vi.h"
#include "contact/vi_solver.h"
#include <memory>

namespace signorini::contact {

/// The step's VI condensed to the m candidates (docs/method.md section 5): with the predicted gaps g⁰ = g(D⁻¹r) it
/// is 0 ≤ λ ⟂ g = g⁰ + Sλ ≥ 0, and y = D⁻¹(r − Nλ). No VI is solved if no predicted gap is negative. Else the
/// set is sought by primal-dual steps from the previous one, which is mostly the right one or a neighbour;
/// where that does not settle it soon, PETSc's VI solver finds it, in the gaps: 0 ≤ g ⟂ S⁻¹(g − g⁰) ≥ 0. S⁻¹,
/// unlike S, is close to an M-matrix, for which reduced-space Newton does not cycle. Where candidates depend
/// on each other S has no inverse, and a dual active-set method finds the set instead; so it does where the
/// other two do not. What LAPACK decides is decided on rank 0.
class CondensedVi final : public ViSolver {
public:
  /// The arguments must outlive this object. PETSc options with the prefix `-condensed_vi_` are honoured.
  CondensedVi(const Constraints& constraints, const Condensation& condensation,
              const Complementarity& complementarity);

  void solve(Vec r, std::span<const double> psi, const ContactSets& previous, ContactState& state,
             Vec y) const override;

private:
  /// PETSc's VI solver of the condensed problem, made when it is first needed.
  struct Petsc {
    petsc::Matrix K; ///< S⁻¹ in units in which its diagonal is about one
    petsc::Vector x, gap0, constant;
    std::unique_ptr<LinearVi> vi;
  };

  /// λ with gap zero on set_, and all the gaps that follow.
  void solve_on_set(ContactState& state) const;
  /// Primal-dual steps until the state holds to rounding, `most` at most; `negligible` (m): to this too.
  void settle(ContactState& state, std::span<const double> psi, double negligible, int most) const;
  /// Whether the state holds to rounding of the step's own motion.
  [[nodiscard]] bool holds(const ContactState& state, std::span<const double> psi) const;
  /// The deepest predicted penetration, m.
  [[nodiscard]] double deepest() const;
  /// Lets PETSc's VI solver find set_, starting from the gaps of `state`.
  void find_set(ContactState& state) const;
  /// Finds set_ one candidate at a time, from no contact, which ends for every S.
  void find_independent_set(ContactState& state) const;
  /// Finds set_ by either of these, whichever can.
  void search(ContactState& state) const;
  /// Gives all ranks what rank 0 found.
  void decided(ContactState& state) const;
  const Petsc& petsc() const;

  const Constraints& constraints_;
  const Condensation& condensation_;
  const Complementarity& complementarity_;
  double length_unit_; ///< of the VI: a negligible gap
  mutable std::vector<double> gap0_, forces_;
  mutable ActiveSet set_, next_;
  mutable DualActiveSet dual_;
  mutable std::unique_ptr<Petsc> petsc_;
};

} // namespace signorini::contact
