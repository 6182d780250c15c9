// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"
#include "fem/space.h"
#include "step/step.h"
#include <optional>

namespace signorini::adjoint {

/// Body of a run of degree 1, discretised in functions of degree 2 on the same mesh. These are sums of
/// functions of degree 1 and bubbles. A bubble vanishes at the vertices; there is one for each edge and
/// component.
class EnrichedBody {
public:
  /// `linear`: the run's space; `pairs`: its contact candidates, null without contact. Collective. The
  /// references must outlive this object. Throws UserError.
  EnrichedBody(const fem::Space& linear, const contact::ContactPairs* pairs, const scene::Scene& scene);
  EnrichedBody(const EnrichedBody&) = delete;
  EnrichedBody& operator=(const EnrichedBody&) = delete;

  [[nodiscard]] const fem::Space& space() const { return space_; }
  [[nodiscard]] const fem::Operators& operators() const { return operators_; }

  /// Sets `out` to the field y of degree 1, written in the basis of degree 2. Collective.
  void embed(Vec y, Vec out) const;

  /// Sets `out` to the interpolation of a field at time t (s) in degree 2, minus its interpolation in the
  /// run's space. This is a combination of bubbles. Collective. Throws UserError as fem::Space::interpolate
  /// does.
  void interpolation_error(const scene::Field& field, double t, Vec out) const;

  /// Interpolation errors (interpolation_error()) of the scene's initial displacement y and velocity v; null
  /// for a field that the scene does not have.
  struct InitialError {
    petsc::Vector y, v;
  };
  [[nodiscard]] const InitialError& initial_error() const { return initial_error_; }

  /// Distributes x over the cells: for each edge, the modulus of the sum of x over its bubbles is shared
  /// equally by the cells at the edge. Returns one number for each owned cell. Collective.
  [[nodiscard]] std::vector<double> by_cells(Vec x) const;

  /// Projects x, in the Euclidean product of the coefficients, onto the bubbles that are free to move.
  /// Afterwards x is zero at vertices and on clamped dofs. It is zero along ν in the middle of an edge whose
  /// ends are both `active` against the same obstacle. Collective.
  void keep_bubbles(const contact::ActiveSet& active, Vec x) const;

private:
  void find_vertices();
  void match(const contact::ContactPairs& pairs);

  const fem::Space& linear_;
  fem::Space space_;
  fem::Operators operators_;
  fem::DirichletDofs clamped_;
  petsc::Matrix embed_;
  std::vector<int> vertices_; ///< vertices among the owned nodes, local numbers
  std::optional<contact::ContactPairs> pairs_;
  std::vector<std::array<int, 2>>
      ends_; ///< for each candidate of pairs_: the run's candidates at the ends of its edge, or −1
  std::vector<double> zero_;
  InitialError initial_error_;
};

/// Adjoint states p and ω of a run at the steps k and k + 1, for k from N down. M ω_k is the derivative by
/// v_k of the part of J after t_k (docs/method.md section 4):
///     ω_N = 0,   ω_{k−1} = τ_k p_k − ω_k
/// For contact-stabilized steps, τ_k (Π_k − 1)(p_k − 2/τ_k ω_k) is added to ω_{k−1}.
class Duals {
public:
  /// `grid`: time grid of the motion. `stepper` must outlive this object. Collective.
  Duals(const step::Stepper& stepper, const step::TimeGrid& grid);

  /// Moves from step k + 1 to step k. `p`: p_k; `later`: contact of step k + 1, null for k = N. Collective.
  void move(int k, Vec p, const contact::ContactLinearisation* later);

  petsc::Vector p, p_later, velocity, velocity_later; ///< p_k, p_{k+1}, ω_k, ω_{k+1}

private:
  const step::Stepper& stepper_;
  step::TimeGrid grid_;
  petsc::Vector work_;
  std::optional<step::PredictorProjection::Workspace> predictor_;
};

/// Bubble part of the adjoint states of the enriched body. π_k = τ_k/2 p_k is the dual of the nodal force of
/// step k, divided by τ_k; β_k is the bubble part of π at t_k. Between steps k and k + 1, the run's adjoint
/// states satisfy the enriched body's adjoint equation up to the residual
///     ρ_k = ∂J/∂y_k + M ((1/τ_{k+1} + 2/τ_k) ω_k − 1/τ_{k+1} ω_{k+1} − p_k) + B (τ_{k+1}/2 p_{k+1} − τ_k/2
///     p_k)
///           − A (τ_k²/4 p_k + τ_{k+1}²/4 p_{k+1})
/// which is zero on V where nothing is in contact. The bubbles solve
///     ((τ_k + τ_{k+1})/2 A + B) β_k = ρ_k + B β_{k+1}
/// Their inertia is neglected, since bubbles respond much faster than the waves that the mesh can resolve.
/// Conjugate gradients with a diagonal preconditioner take a few iterations on any mesh, since only
/// neighbouring bubbles are coupled (hierarchical error estimate, Bank and Smith 1993; docs/method.md
/// section 7).
class DualBubbles {
public:
  /// `derivative`: ∂J/∂y_k on the enriched body; `grid`: time grid of the motion. Collective. The references
  /// must outlive this object.
  DualBubbles(const EnrichedBody& body, const step::DualAtStep& derivative, const step::TimeGrid& grid);

  /// Computes and returns β_k on the active set `active` of step k; to be called for k from N − 1 down. Valid
  /// until the next call. Collective. Throws SolverFailure.
  Vec next(int k, const Duals& duals, const contact::ActiveSet& active);

  /// Returns β_k of the last call of next(); zero before the first call.
  [[nodiscard]] Vec last() const { return b_; }

private:
  /// Sets left_ to the right-hand side ρ_k + B β_{k+1}.
  void residual(int k, const Duals& duals);
  /// Adds factor · matrix · coarse_ to left_, with coarse_ written in degree 2.
  void add(Mat matrix, double factor);
  /// Sets the mean length (s) of the two steps that meet at t_k, and the preconditioner for it.
  void set_length(double mean);
  /// Sets out = (τ A + B) x, τ the mean length of two steps, restricted to the bubbles that are free to move.
  void apply(Vec x, const contact::ActiveSet& active, Vec out);
  /// Sets z_ = left_ / diagonal_, restricted to the bubbles that are free to move; returns z_·left_.
  double apply_preconditioner(const contact::ActiveSet& active);

  const EnrichedBody& body_;
  const step::DualAtStep& derivative_;
  step::TimeGrid grid_;
  double mean_ = 0;
  petsc::Vector coarse_, b_, left_, z_, direction_, image_, work_, of_A_, of_B_, diagonal_;
};

} // namespace signorini::adjoint
