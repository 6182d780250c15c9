#pragma once
#include "contact/condensation.h"
#include "contact/linear_vi.h"
#include "contact/vi_solver.h"
#include <optional>

namespace signorini::contact {

/// The step's VI condensed to the m candidates (method.md section 6): with the predicted gaps g⁰ = g(D⁻¹r) it is
/// 0 ≤ λ ⟂ g = g⁰ + Sλ ≥ 0, and y = D⁻¹(r − Nλ). No VI is solved if no predicted gap is negative, nor if the previous
/// active set turns out to be the right one; else PETSc's VI solver finds the set, in the gaps: 0 ≤ g ⟂ S⁻¹(g − g⁰) ≥ 0.
/// S⁻¹, unlike S, is close to an M-matrix, for which reduced-space Newton does not cycle. Solved on every rank alike.
class CondensedVi final : public ViSolver {
public:
  /// Collective. The arguments must outlive this object. PETSc options with the prefix `-condensed_vi_` are honoured.
  CondensedVi(const Constraints& constraints, const Condensation& condensation, const Factorisation& D,
              const Complementarity& complementarity);

  ContactState solve(Vec r, const ContactState& previous, Vec y) const override;

private:
  /// λ with gap zero on `set`, and all the gaps that follow.
  void solve_on(const ActiveSet& set, std::span<const double> gap0, ContactState& state) const;
  /// The active set that PETSc's VI solver finds, starting from the gaps of a guess.
  ActiveSet find_set(std::span<const double> gap0, std::span<const double> guess, int& iterations) const;

  const Constraints& constraints_;
  const Condensation& condensation_;
  const Factorisation& D_;
  const Complementarity& complementarity_;
  double length_unit_; ///< of the VI: a negligible gap
  petsc::Matrix K_;    ///< S⁻¹ in units in which its diagonal is about one
  petsc::Vector x_, gap0_, constant_;
  std::optional<LinearVi> vi_;
};

} // namespace signorini::contact
