#pragma once
#include "contact/condensation.h"
#include "contact/linear_vi.h"
#include "contact/vi_solver.h"
#include <optional>

namespace signorini::contact {

/// The step's VI in its dual, in the m contact forces alone (method.md section 6):
/// 0 ≤ λ ⟂ Sλ + g(D⁻¹r) ≥ 0, then y = D⁻¹(r − Nλ). No VI is solved if no predicted gap is negative, nor if the previous
/// active set turns out to be the right one; else PETSc's VI solver finds the set. Solved on every rank alike.
class CondensedVi final : public ViSolver {
public:
  /// Collective. The arguments must outlive this object. PETSc options with the prefix `-condensed_vi_` are honoured.
  CondensedVi(const Constraints& constraints, const Condensation& condensation, const Factorisation& D,
              const Complementarity& complementarity, Vec layout);

  ContactState solve(Vec r, const ContactState& previous, Vec y) const override;

private:
  /// λ with gap zero on `set`, and all the gaps that follow.
  void solve_on(const ActiveSet& set, std::span<const double> gap0, ContactState& state) const;
  /// The active set that PETSc's VI solver finds.
  ActiveSet find_set(std::span<const double> gap0, const ContactState& previous, int& iterations) const;

  const Constraints& constraints_;
  const Condensation& condensation_;
  const Factorisation& D_;
  const Complementarity& complementarity_;
  double length_unit_, force_unit_; ///< of the VI: a negligible gap, and the force that makes it
  petsc::Matrix S_;                 ///< S in these units
  petsc::Vector x_, gap0_, work_;
  std::optional<LinearVi> vi_;
};

} // namespace signorini::contact
