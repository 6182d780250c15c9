#pragma once
#include "contact/constraints.h"
#include "fem/enrichment.h"
#include "forward/step.h"
#include "forward/trajectory.h"
#include <optional>

namespace signorini::adjoint {

/// The body in functions of degree 2 on the mesh of a run of degree 1: what the run's equation of motion leaves over there
/// is its residual in space.
class EnrichedBody {
public:
  /// `linear` is the run's space and `constraints` its contact, null without. Collective. The references must outlive this
  /// object. Throws UserError.
  EnrichedBody(const fem::Space& linear, const contact::Constraints* constraints, const scene::Scene& scene);
  EnrichedBody(const EnrichedBody&) = delete;
  EnrichedBody& operator=(const EnrichedBody&) = delete;

  [[nodiscard]] const fem::Space& space() const { return space_; }
  [[nodiscard]] const fem::Operators& operators() const { return operators_; }
  [[nodiscard]] const fem::Enrichment& enrichment() const { return enrichment_; }

  /// p⁺ − p for an adjoint state p on an active set: recovered, but zero where clamps hold and, along ν, in the middle of
  /// edges whose ends are both in contact with the same obstacle. Collective.
  void surplus(Vec p, const contact::ActiveSet& active, Vec out) const;

private:
  void match(const contact::Constraints& constraints);

  fem::Space space_;
  fem::Operators operators_;
  fem::Clamped clamped_;
  fem::Enrichment enrichment_;
  std::optional<contact::Constraints> constraints_;
  std::vector<std::array<int, 2>> ends_; ///< of each candidate here the run's candidates at the ends of its edge, or −1
  std::vector<double> zero_;
};

/// What an error costs J: J(exact) − J(computed), to first order.
struct ErrorParts {
  std::optional<double> space; ///< of the mesh's elements, not of its boundary; absent for degree 2
  double time = 0;
};

/// The adjoint-weighted residual of a computed motion (Becker and Rannacher 2001), active sets frozen, by one backward sweep.
///
/// Space: with a = (v_k − v_{k−1})/τ, w = (y_k − y_{k−1})/τ, in functions of degree 2,
///     Σ_k τ²/2 (p_k⁺ − p_k)·(f_k + s W u_k − M a − B w − A (y_{k−1} + y_k)/2)
/// Time: y is taken as piecewise quadratic, with the run's v piecewise linear, and π = τ/2 p as the dual of a force per time;
/// what is left of the equation of motion within the steps weighs
///     −τ²/12 ∫ π'·(2 A v + B v') dt + τ²/24 ∫ π'·f' dt − τ²/12 π(0)·A v_0 − τ²/24 π(0)·f'(0)
///
/// `trajectory` has velocities; `enriched` is null without a space part; `load` acted on the run, `enriched_load` is the same in functions of degree 2,
/// `derivative` is ∂J/∂y_k given like a load. Collective. Throws SolverFailure.
ErrorParts weighted_residual(const forward::Stepper& stepper, const EnrichedBody* enriched, const forward::Trajectory& trajectory,
                             const forward::Load& load, const forward::Load& enriched_load, const forward::Load& derivative);

} // namespace signorini::adjoint
