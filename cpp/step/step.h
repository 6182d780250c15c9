// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "contact/pairs.h"
#include "fem/operators.h"
#include "linalg/lane_product.h"
#include "step/load.h"
#include "step/moving_clamps.h"
#include "step/predictor_projection.h"
#include "step/step_operators.h"
#include <algorithm>
#include <optional>
#include <span>
#include <utility>

namespace signorini::contact {
struct LawFailure;
}

namespace signorini::step {

/// State of a motion, or of a linearised motion, at one time: a list of vectors of V, its parts. They are the
/// displacement y (m), the velocity v (m/s) and the internal displacements q_j (m) of the branches of
/// materials that relax. A state that stores displacements alone has one part.
class State {
public:
  /// Creates a zero state of `parts` vectors with the layout of `like`. Collective.
  State(Vec like, std::size_t parts) : parts_(petsc::zero_series(like, parts)) {}

  [[nodiscard]] Vec y() const { return parts_[0]; }
  [[nodiscard]] Vec v() const { return parts_[1]; }
  [[nodiscard]] std::span<const petsc::Vector> parts() const { return parts_; }
  /// Returns the internal displacements q_j, in the order of fem::Relaxation::branches().
  [[nodiscard]] std::span<const petsc::Vector> q() const {
    return parts().subspan(std::min(own_parts, parts_.size()));
  }
  static constexpr std::size_t own_parts = 2; ///< number of parts of a body that does not relax: y and v

  /// Copies from `other` as many parts as this state has; `other` must have at least as many. Collective.
  void copy(const State& other) {
    for (std::size_t i = 0; i < parts_.size(); ++i)
      petsc::check(VecCopy(other.parts_[i], parts_[i]));
  }

private:
  petsc::Series parts_;
};

/// Adjoint variables that a backward sweep passes from step k + 1 to step k (docs/method.md section 4).
struct AdjointState {
  petsc::Vector p, p_next; ///< p_k (before step k a guess of it) and p_{k+1}
  petsc::Vector omega;     ///< ω_{k+1} before step k, ω_k after it
  petsc::Series z;         ///< of step k + 1 before step k, then of step k: A_j z_j is the dual of q_j,k
  petsc::Vector slip; ///< T μ_t of step k + 1 before step k, then of step k: its friction's dual of y; null
                      ///< without friction

  /// Creates the adjoint state after step N, which is zero, for a body with `branches` branches. Collective.
  AdjointState(Vec like, std::size_t branches)
      : p(petsc::zero_like(like)), p_next(petsc::zero_like(like)), omega(petsc::zero_like(like)),
        z(petsc::zero_series(like, branches)) {}

  /// Makes p_k the p_next of step k − 1.
  void advance() { std::swap(p, p_next); }
};

/// Inputs of step k, from t_{k−1} to t_k.
struct StepInput {
  TimeStep step;
  const State& from;                             ///< state at t_{k−1}
  NodalForce load;                               ///< force f_k + s u_k in the step
  const contact::ContactLinearisation& previous; ///< contact in step k − 1
};

/// Results of step k. `contact` must be created by Stepper::contact_state(). If the solver takes a guess,
/// to.y() contains the guess on entry.
struct StepOutput {
  State& to; ///< state at t_k
  contact::ContactState& contact;
};

/// Data of a linearised step k, which leads from the state (δy, δv) at t_{k−1} to the state at t_k. `load` is
/// δf_k, the linearised change of step k's force. The active set is passed separately.
struct LinearisedStep {
  Scheme scheme;
  const State& from;
  NodalForce load;
  State& to;                        ///< (δy, δv) at t_k; on entry y() is a guess as in StepOutput
  std::span<const double> normal{}; ///< prescribed Hᵀδy on the active set (rows, m); empty: zero
  std::span<double> multipliers{};  ///< δλ on return (rows); empty: not computed
  std::span<const double>
      law{}; ///< with friction: right-hand sides of the linearised laws (rows); empty: zero
  const PredictorProjection::Data* predictor = {}; ///< data of an inhomogeneous projection to δz; else null
};

/// Scheme and contact of a step, which determine its derivative.
struct StepContact {
  Scheme scheme;
  const contact::ContactLinearisation& contact;
};

/// Data of a transposed step, from step k + 1 to step k.
struct AdjointStep {
  StepContact step;                 ///< step k
  std::optional<StepContact> next;  ///< step k + 1; none for k = N
  StateDual derivative;             ///< ∂J/∂y_k
  AdjointState& state;              ///< adjoint of step k + 1 on entry, of step k on return
  std::span<const double> normal{}; ///< prescribed Hᵀp_k = ∂J/∂λ_k on the active set (rows); empty: zero
  std::span<double> multipliers{};  ///< μ_k on return (rows); empty: not computed
  std::span<double> law_duals{};    ///< with friction: minus the derivatives by the right-hand sides of the
                                    ///< linearised laws on return (rows); empty: not computed
  const PredictorProjection::Data* predictor = {}; ///< data of an inhomogeneous projection of s_{k+1} (see
                                                   ///< Stepper::adjoint_step()); else null
};

/// Makes time steps, linearised steps and transposed steps (docs/method.md sections 2 and 4). Stores the data
/// that no step changes: operators, a factorisation of D for each step length, contact candidates and their
/// solver. A step depends on its arguments alone; all scratch is in the workspace.
class Stepper {
public:
  /// Requirements of a run that determine the choice of solvers.
  struct Needs {
    bool derivatives = false; ///< whether linearised or transposed steps are needed
    double passes = 0;        ///< expected passes over all steps; 0: the solver is chosen by memory alone
    bool iterative = false;   ///< whether the solver must be iterative, as that of the resumed run was
  };

  /// Finds the contact candidates, and assembles and factorises D for the first step length. Collective. The
  /// references must outlive this object. Throws UserError, SolverFailure.
  /// `like`: a stepper of a scene with the same operators_key(), whose matrices and factorisations are used
  /// as far as they are the same; it must outlive this object.
  Stepper(const fem::Space& space, const fem::Operators& operators, const scene::Scene& scene, Needs needs,
          const Stepper* like = nullptr);

  Stepper(const Stepper&) = delete; // its members refer to each other
  Stepper& operator=(const Stepper&) = delete;

  /// Returns the lengths that automatic steps may have; null if all steps have the length time.step.
  [[nodiscard]] const StepLengths* step_lengths() const { return step_lengths_ ? &*step_lengths_ : nullptr; }
  /// Returns the end time of the motions, s.
  [[nodiscard]] double end() const { return end_; }
  /// Returns the length assumed for the first step before its length is chosen, s: time.step or, with
  /// automatic steps, the shortest length.
  [[nodiscard]] double first_length() const { return first_length_; }
  [[nodiscard]] const fem::Space& space() const { return space_; }
  [[nodiscard]] const fem::Operators& operators() const { return operators_; }
  [[nodiscard]] const fem::DirichletDofs& clamped() const { return clamped_; }
  /// Returns the solver of the step length used last; other lengths use the same method. Valid until the next
  /// step.
  [[nodiscard]] const SolverChoice& solver() const { return *lengths_->latest().solver; }
  /// Returns the operators and the solver of step length `tau` (s), factorised if necessary; valid until the
  /// next step. Collective.
  [[nodiscard]] const StepOperators::PerStepLength& of_length(double tau) const { return lengths_->at(tau); }
  /// Makes the solves together that the tasks of `lockstep` ask for in steps of length `tau` (s); null: no
  /// more. Returns whether the solver does that. Collective.
  bool unite(double tau, Lockstep* lockstep) const {
    if (predictor_)
      predictor_->unite(lockstep);
    product_->unite(lockstep);
    return of_length(tau).solver->unite(lockstep);
  }
  /// Number of factorisations so far, repeated ones included.
  [[nodiscard]] int factorisations() const { return lengths_->factorisations(); }
  /// Total time of the factorisations, s.
  [[nodiscard]] double factorisation_seconds() const { return lengths_->factorisation_seconds(); }
  [[nodiscard]] scene::ContactScheme contact_scheme() const { return contact_scheme_; }
  /// Returns the mass matrix M of this run: the body's or, if contact nodes lose mass, EᵀME (docs/method.md
  /// section 2).
  [[nodiscard]] Mat M() const { return moved_->mass ? Mat(moved_->mass) : Mat(operators_.M); }
  /// Returns the extrapolation E of velocities to contact nodes if it acts on states, which it does where
  /// contact nodes have no tangential mass; else null.
  [[nodiscard]] Mat velocity_extrapolation() const { return moved_->extrapolation; }
  /// Replaces the velocity v by E v if velocity_extrapolation() is not null. `work`: scratch. Collective.
  void extrapolate(Vec v, Vec work) const;
  /// Returns the projection of the predictor; null except in contact-stabilized stepping.
  [[nodiscard]] const PredictorProjection* predictor() const { return predictor_ ? &*predictor_ : nullptr; }
  /// Returns the moving clamps; null if no clamp moves.
  [[nodiscard]] const MovingClamps* moving_clamps() const {
    return moving_clamps_ ? &*moving_clamps_ : nullptr;
  }
  /// Returns the contact candidates; null without contact.
  [[nodiscard]] const contact::ContactPairs* pairs() const { return pairs_ ? &*pairs_ : nullptr; }

  /// Returns the least time in which a pressure wave crosses an element, s, over the elements at contact
  /// groups and at tractions that vary in time. It covers all elements if a body load varies in time or there
  /// is no contact.
  [[nodiscard]] double wave_time() const { return wave_time_; }

  /// Returns the number of constraint rows, 0 without contact.
  [[nodiscard]] std::size_t rows() const {
    return pairs_ ? static_cast<std::size_t>(pairs_->rows().count()) : 0;
  }
  /// Creates a contact state for all candidates, in which none is in contact.
  [[nodiscard]] contact::ContactState contact_state() const {
    return pairs_ ? contact::ContactState(pairs_->count(), pairs_->rows().count()) : contact::ContactState();
  }
  /// Creates a zero state. Collective.
  [[nodiscard]] State state() const { return {space_.vector(), state_parts()}; }
  /// Returns the number of branches of all materials that relax.
  [[nodiscard]] std::size_t branches() const {
    return operators_.relaxation ? operators_.relaxation->branches().size() : 0;
  }
  /// Returns the number of vectors of a full state.
  [[nodiscard]] std::size_t state_parts() const { return State::own_parts + branches(); }
  /// Creates the zero adjoint state after step N. Collective.
  [[nodiscard]] AdjointState adjoint_state() const;
  /// Whether candidates have friction.
  [[nodiscard]] bool frictional() const { return pairs_ && !pairs_->rows().symmetric(); }

  /// Returns the memory of the predictor's projection on all ranks, bytes. Collective.
  [[nodiscard]] double predictor_bytes() const;
  /// Returns the memory of the redistributed mass on all ranks, bytes. Collective.
  [[nodiscard]] double redistribution_bytes() const;

  /// Scratch of steps, for one step at a time. No step depends on the content that an earlier step left.
  struct Workspace {
    petsc::Vector r{}, work{}, moved{};
    petsc::Vector of_branches{};                ///< argument of a branch product; null without branches
    std::vector<double> weights{}, weights_p{}; ///< factors of one vector, and of p, for each branch
    double tau = 0;                             ///< length of the step for which `contact` was used last, s
    std::optional<contact::ContactPairs::Gaps> gaps{};
    std::vector<double> slip_gaps{}, motion{}, mu{}; ///< with friction: ψ, Hᵀy and multipliers (rows)
    std::optional<contact::Workspace> contact{};
    std::optional<PredictorProjection::Workspace> predictor{};
    std::optional<MovingClamps::Evaluation> moving_clamps{};
  };
  /// Creates a workspace. Collective.
  [[nodiscard]] Workspace workspace() const;

  /// Makes step k, with obstacles at their positions of time t_k. Allocates nothing, except within PETSc:
  /// with MUMPS, and with contact as one inequality in all unknowns (solver.vi). Collective. Throws
  /// UserError, SolverFailure.
  void step(const StepInput& in, const StepOutput& out, Workspace& work) const;

  /// Makes a linearised step on the active set of `contact`, the contact of that step (docs/method.md section
  /// 4). Collective.
  void linearised_step(const LinearisedStep& step, const contact::ContactLinearisation& contact,
                       Workspace& work) const;

  /// Makes a one-sided linearised step: weakly active candidates may open, so that δy·ν ≤ 0 replaces δy·ν = 0
  /// there (docs/method.md section 4). On return the active set of `contact` is the set C of candidates that
  /// stay closed; linearised_step() on C gives the same result. Collective. Throws SolverFailure.
  void one_sided_step(const LinearisedStep& step, contact::ContactLinearisation& contact,
                      Workspace& work) const;

  /// Makes a transposed step (4.40)–(4.41) by the formula at Scheme: computes p_k and ω_k in step.state. M
  /// ω_k is the derivative by v_k of the part of J after t_k; p and ω are zero at k = N + 1. The derivative
  /// of J by step k's nodal force is Scheme::impulse() p_k. Returns the jump of s_{k+1} = p_{k+1} − rate()
  /// ω_{k+1}, null without a jump. Collective.
  Vec adjoint_step(const AdjointStep& step, Workspace& work) const;

  /// Ends a backward sweep, with `step` for k = 0. Sets ω_0 and stores in step.state.p, in place of p_0, the
  /// derivative of J by y_0, a functional on the free dofs. Returns the jump of s_1, null without a jump.
  /// Collective.
  Vec adjoint_start(const AdjointStep& step, Workspace& work) const;

private:
  /// Moves mass of contact nodes to other nodes, and sets moved_.
  void move_mass(const scene::Scene& scene);
  /// Sets up the projection of the predictor.
  void add_predictor(const scene::Scene& scene, const scene::Solver& solver, bool derivatives, double solves,
                     const Stepper* like);
  /// Sets work.r = R x + a M z + b source on the free dofs and zero on the clamped ones, for steps and
  /// transposed steps.
  void right_hand_side(Mat R, Vec x, double a, Vec z, double b, Functional source, Workspace& work) const;
  /// Subtracts impulse() Σ_j gain_j A_j q_j,k−1 from work.r on the free dofs. `from`: state at t_{k−1}.
  void subtract_branch_forces(const Scheme& scheme, const State& from, Workspace& work) const;
  /// Sets q_j,k = decay_j q_j,k−1 + gain_j (y_k − y_{k−1}) in `to`, whose displacement is y_k.
  void set_branches(const Scheme& scheme, const State& from, const State& to) const;
  /// Adds the duals of the branches to work.r, c_j A_j z_j,k − c_j' A_j z_j,k+1 with the gains c_j of step k
  /// (zero for k = 0) and c_j' of step k + 1, and sets z_j,k in `step.state`.
  void add_branch_duals(const AdjointStep& step, bool start, Workspace& work) const;
  /// Sets work.r for a linearised step. Returns the predictor's jump, null without a jump.
  Vec linearised_right_hand_side(const LinearisedStep& step, const contact::ContactLinearisation& contact,
                                 Workspace& work) const;
  /// Returns the message of a failure, with the place of the candidate.
  [[nodiscard]] std::string described(const contact::LawFailure& failure) const;
  /// Sets work.slip_gaps to the gaps ψ (rows, m) of a step with friction: `psi` on normal rows, and Tᵀy_{k−1}
  /// plus the ways of the obstacles on tangential ones.
  void set_slip_gaps(const StepInput& in, std::span<const double> psi, Workspace& work) const;
  /// Solves a linearised step with friction to one side, for the right-hand side work.r; replaces the active
  /// set and the equations of `contact` by those on which the solution is linear.
  void solve_one_sided_slip(const LinearisedStep& step, contact::ContactLinearisation& contact,
                            Workspace& work) const;
  /// Sets `dual` to T μ_t, by which the slip of a step depends on the displacement at its start. `mu`: rows.
  void set_slip_dual(std::span<const double> mu, Vec dual, Workspace& work) const;
  /// Returns `value` (rows; empty: zero) plus Tᵀδy_{k−1} on the tangential rows; `value` itself without
  /// friction.
  std::span<const double> with_slip(std::span<const double> value, const State& from, Workspace& work) const;
  /// Returns the contact solver of a step length, null without contact. Resets its scratch in `work` if that
  /// was used for another length.
  const contact::ContactStepSolver* contact_solver(const StepOperators::PerStepLength& with,
                                                   Workspace& work) const;
  enum class Direction { linearised, transposed };
  /// Solves a linearised or transposed step with the right-hand side work.r on the active set of `contact`.
  /// `value` and `multipliers`: as in contact::LinearisedContact.
  void solve_on_active_set(double tau, Direction direction, const contact::ContactLinearisation& contact,
                           std::span<const double> value, Vec x, std::span<double> multipliers,
                           Workspace& work, std::span<const double> law = {},
                           std::span<double> law_duals = {}) const;
  /// Computes ω_k of a transposed step from ω_{k+1}, and sets work.r = R p_{k+1} + M (rate ω_k − rate_{k+1}
  /// ω_{k+1} + j) + ∂J/∂y_k; for k = N only ∂J/∂y_N. `rate`: 2/τ_k, or 0 for k = 0. Returns the jump of
  /// s_{k+1}, null without a jump.
  Vec transposed_right_hand_side(const AdjointStep& step, double rate, Workspace& work) const;
  /// Solves a linearised step with right-hand side r = work.r whose weakly active candidates W may open: min
  /// ½ p·Dp − r·p over p·ν = 0 on the strongly active set S, p·ν ≤ 0 on W. The set that stays closed becomes
  /// the active set of `contact`.
  void solve_one_sided(const Scheme& scheme, contact::ContactLinearisation& contact, Vec p,
                       Workspace& work) const;

  const fem::Space& space_;
  const fem::Operators& operators_;
  scene::ContactScheme contact_scheme_;
  double wave_time_;
  std::optional<StepLengths> step_lengths_;
  double end_, first_length_;
  fem::DirichletDofs clamped_;
  std::optional<MovingClamps> moving_clamps_;
  std::optional<contact::ContactPairs> pairs_;
  std::optional<contact::ContactPairs>
      smooth_pairs_; ///< pairs_ without friction, for the predictor; else absent
  /// Mass matrices of a run whose contact nodes lose mass; null in other runs.
  struct MovedMass {
    petsc::Matrix body, redistributed; ///< mass matrix of the body, and EᵀME, in blocks
    petsc::Matrix mass;                ///< symmetric half of EᵀME
    petsc::Matrix extrapolation;       ///< E if contact nodes have no tangential mass; else null
    petsc::Matrix predictor;           ///< mass matrix of the predictor where EᵀME is singular; else null
  };
  std::shared_ptr<MovedMass> moved_ = std::make_shared<MovedMass>(); ///< changed at construction only
  std::optional<PredictorProjection> predictor_;
  std::optional<StepOperators> lengths_;
  std::shared_ptr<LaneProduct> product_; ///< with R of the length first_length_, and M
};

} // namespace signorini::step
