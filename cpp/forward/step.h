#pragma once
#include "fem/operators.h"
#include "forward/load.h"
#include "forward/motion.h"
#include "forward/predictor.h"
#include "forward/step_solver.h"
#include <optional>

namespace signorini::forward {

/// Makes time steps and their derivatives (docs/method.md sections 2 and 4), and holds what no step changes:
/// the operators, D factorised once, and, where the scene has contact, the constraints and their solver.
class Stepper {
public:
  /// Which contact objects a run needs.
  struct Needs {
    bool sliding = false; ///< linearised or transposed steps
  };

  /// Assembles and factorises. Collective. The references must outlive this object. Throws UserError,
  /// SolverFailure.
  Stepper(const fem::Space& space, const fem::Operators& operators, const scene::Scene& scene, Needs needs);

  Stepper(const Stepper&) = delete; // its parts refer to each other
  Stepper& operator=(const Stepper&) = delete;

  [[nodiscard]] const Scheme& scheme() const { return scheme_; }
  [[nodiscard]] const fem::Space& space() const { return space_; }
  [[nodiscard]] const fem::Operators& operators() const { return operators_; }
  [[nodiscard]] const fem::DirichletDofs& clamped() const { return clamped_; }
  [[nodiscard]] const StepSolver& solver() const { return *solver_; }
  /// Whether contact nodes carry no mass.
  [[nodiscard]] bool massless() const { return massless_.has_value(); }
  /// The mass matrix M of this run: the body's, or with massless contact EᵀME (docs/method.md section 2).
  [[nodiscard]] Mat M() const { return massless_ ? Mat(*massless_) : Mat(operators_.M); }
  /// Null except in contact-stabilized stepping.
  [[nodiscard]] const Predictor* predictor() const { return predictor_ ? &*predictor_ : nullptr; }
  /// Null where no clamp moves.
  [[nodiscard]] const PrescribedMotion* motion() const { return motion_ ? &*motion_ : nullptr; }
  /// R = D − 2 stiffness() A.
  [[nodiscard]] Mat R() const { return R_; }
  /// Null without contact.
  [[nodiscard]] const contact::Constraints* constraints() const {
    return constraints_ ? &*constraints_ : nullptr;
  }

  /// Memory of what the scheme adds to contact-implicit stepping, bytes. Collective.
  [[nodiscard]] double scheme_bytes() const;

  /// Step k from (y0, v0) under `load` to (y1, v1) and the contact there, with obstacles where they are at
  /// t_k; `previous` is the contact at y0, and y1 holds a guess on entry if solver().takes_guess(). Allocates
  /// nothing, except within PETSc in VIs that PETSc solves and with MUMPS. Collective. Throws UserError,
  /// SolverFailure.
  void step(int k, Vec y0, Vec v0, NodalForce load, const contact::ContactSets& previous,
            contact::ContactState& contact, Vec y1, Vec v1) const;

  /// The step linearised on the active set of `contact` (docs/method.md section 4): (δy0, δv0, δload) → (δy1,
  /// δv1); y1 as in step(). Collective.
  void linearised_step(Vec y0, Vec v0, NodalForce load, const contact::ContactSets& contact, Vec y1,
                       Vec v1) const;

  /// The one-sided derivative of the step: as linearised_step(), but weakly active candidates may open, x·ν ≤
  /// 0 there in place of 0 (docs/method.md section 4). On return the active set of `contact` is the set C
  /// that stays closed, on which linearised_step() gives the same. Collective. Throws SolverFailure.
  void one_sided_step(Vec y0, Vec v0, NodalForce load, contact::ContactSets& contact, Vec y1, Vec v1) const;

  /// The transpose of linearised_step on the active set of `contact` (4.40)–(4.41), with the paper's adjoint
  /// states:
  ///     D p_k − μ_k = R p_{k+1} − τ M q_{k+1} + ∂J/∂y_k,   q_k = −q_{k+1} + rate() (p_{k+1} − p_k)
  /// and in contact-stabilized stepping, with j = Π_{k+1} q_{k+1} − q_{k+1} (the transpose of the step of
  /// docs/method.md section 2, with M (τ/2 p + τ²/4 q) the dual of the velocity),
  ///     D p_k − μ_k = R p_{k+1} − τ M (q_{k+1} + 3/2 j) + ∂J/∂y_k,
  ///     q_k = −q_{k+1} − 2 j + rate() (p_{k+1} − p_k)
  /// `next` is the contact of step k + 1, null at N; `derivative` is ∂J/∂y_k. `q` is q_{k+1} on entry and q_k
  /// on return; `p_next` is p_{k+1}; `p` becomes p_k and holds a guess on entry as y1 in step(). Both adjoint
  /// states are zero at k = N + 1. The dual of step k's nodal force is impulse() p_k. Collective.
  void adjoint_step(const contact::ContactSets& contact, const contact::ContactSets* next,
                    StateDual derivative, Vec p_next, Vec q, Vec p) const;

private:
  /// Replaces the mass in `D` by that of massless contact, and sets massless_.
  void move_mass(const scene::Scene& scene, Mat D);
  /// r_ = R x + a M z + b source on the free dofs, zero on the clamped ones: of steps and adjoint steps.
  void right_hand_side(Vec x, double a, Vec z, double b, Functional source) const;
  /// x + c j, or x itself without a jump j.
  Vec with_jump(Vec x, double c, Vec jump) const;
  /// y + τ v.
  Vec predicted(Vec y, Vec v) const;
  /// v1 = 2/τ (y1 − y0 − jump) − v0.
  void velocity(Vec y0, Vec v0, Vec jump, Vec y1, Vec v1) const;
  /// r_ of a linearised step; returns the predictor's jump, null without one.
  Vec linearised_right_hand_side(Vec y0, Vec v0, NodalForce load, const contact::ContactSets& contact) const;
  /// Solves with r_ on an active set.
  void solve_sliding(const contact::ActiveSet& active, Vec p) const;
  /// solve_sliding() where weakly active candidates may open: min ½ p·Dp − r·p over p·ν = 0 on S, p·ν ≤ 0 on
  /// W. The set that stays closed becomes the active one.
  void solve_one_sided(contact::ContactSets& contact, Vec p) const;

  const fem::Space& space_;
  const fem::Operators& operators_;
  Scheme scheme_;
  fem::DirichletDofs clamped_;
  double clamped_diagonal_ = 0; ///< of D on the clamped dofs
  std::optional<PrescribedMotion> motion_;
  petsc::Matrix R_;
  petsc::Vector r_, work_, moved_;
  std::optional<contact::Constraints> constraints_;
  std::optional<petsc::Matrix> massless_;
  std::optional<Predictor> predictor_;
  std::optional<StepSolver> solver_;
};

} // namespace signorini::forward
