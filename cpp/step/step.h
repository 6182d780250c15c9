// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include "contact/pairs.h"
#include "fem/operators.h"
#include "step/load.h"
#include "step/moving_clamps.h"
#include "step/predictor_projection.h"
#include "step/step_operators.h"
#include <optional>
#include <span>
#include <utility>

namespace signorini::step {

/// The state of a motion, or of a linearised one, at one time: vectors of V, of which the first is the
/// displacement y (m) and the second the velocity v (m/s). Code that stores or copies states treats all
/// parts alike.
class State {
public:
  /// Makes a zero state of `parts` vectors in the layout of `like`. Collective.
  State(Vec like, std::size_t parts) : parts_(petsc::zero_series(like, parts)) {}

  [[nodiscard]] Vec y() const { return parts_[0]; }
  [[nodiscard]] Vec v() const { return parts_[1]; }
  [[nodiscard]] std::span<const petsc::Vector> parts() const { return parts_; }

  /// Copies the parts that this state has from `other`, which has them all. Collective.
  void copy(const State& other) {
    for (std::size_t i = 0; i < parts_.size(); ++i)
      petsc::check(VecCopy(other.parts_[i], parts_[i]));
  }

private:
  petsc::Series parts_;
};

/// Adjoint variables that a backward sweep passes from step k + 1 to step k (docs/method.md section 4).
struct AdjointState {
  petsc::Vector p, p_next; ///< p_k, a guess before step k, and p_{k+1}
  petsc::Vector omega;     ///< ω_{k+1}, after step k ω_k

  /// Makes the zero adjoint state after step N. Collective.
  explicit AdjointState(Vec like)
      : p(petsc::zero_like(like)), p_next(petsc::zero_like(like)), omega(petsc::zero_like(like)) {}

  /// Moves on to step k − 1.
  void advance() { std::swap(p, p_next); }
};

/// Inputs of step k.
struct StepInput {
  TimeStep step;
  const State& from;                             ///< at t_{k−1}
  NodalForce load;                               ///< f_k + s u_k
  const contact::ContactLinearisation& previous; ///< contact at t_{k−1}
};

/// Results of a step; `contact` is constructed for the candidates, and to.y() is a guess on entry if the
/// solver takes one.
struct StepOutput {
  State& to; ///< at t_k
  contact::ContactState& contact;
};

/// A linearised step of (δy, δv) under δload on the active set of `contact`, that of step k.
struct LinearisedStep {
  Scheme scheme;
  const State& from;
  NodalForce load;
  State& to;                                       ///< δ of the state at t_k; y() as in StepOutput
  std::span<const double> normal{};                ///< Hᵀδy on the active set (m), zero if empty
  std::span<double> multipliers{};                 ///< δλ on return (m), not computed if empty
  const PredictorProjection::Data* predictor = {}; ///< data of δz, null: none
};

/// Scheme and contact of a step, which determine its derivative.
struct StepContact {
  Scheme scheme;
  const contact::ContactLinearisation& contact;
};

/// A transposed step, from step k + 1 to k.
struct AdjointStep {
  StepContact step;                                ///< k
  std::optional<StepContact> next;                 ///< k + 1, none at N
  StateDual derivative;                            ///< ∂J/∂y_k
  AdjointState& state;                             ///< adjoint of step k + 1 on entry, of step k on return
  std::span<const double> normal{};                ///< Hᵀp_k = ∂J/∂λ_k on the active set (m), zero if empty
  std::span<double> multipliers{};                 ///< μ_k on return (m), not computed if empty
  const PredictorProjection::Data* predictor = {}; ///< data of the projection of s_{k+1}, null: none
};

/// Makes time steps and their derivatives (docs/method.md sections 2 and 4), and stores what no step changes:
/// the operators, D factorised once for each length of steps, and, where the scene has contact, the pairs and
/// their solver. A step depends on its arguments alone; all scratch is in the workspace.
class Stepper {
public:
  /// Needs of a run, for the choice of solvers.
  struct Needs {
    bool derivatives = false; ///< linearised or transposed steps
    double passes = 0;        ///< expected passes over all steps; 0: the solver is chosen by memory alone
    bool iterative = false;   ///< whether the resumed run used an iterative solver
  };

  /// Assembles and factorises for the first step. Collective. The references must outlive this object. Throws
  /// UserError, SolverFailure.
  Stepper(const fem::Space& space, const fem::Operators& operators, const scene::Scene& scene, Needs needs);

  Stepper(const Stepper&) = delete; // its parts refer to each other
  Stepper& operator=(const Stepper&) = delete;

  /// The lengths that steps may have; null if all have the scene's.
  [[nodiscard]] const StepLengths* step_lengths() const { return step_lengths_ ? &*step_lengths_ : nullptr; }
  /// The end of motions, s.
  [[nodiscard]] double end() const { return end_; }
  /// The length of a first step of which none is chosen yet, s.
  [[nodiscard]] double first_length() const { return first_length_; }
  [[nodiscard]] const fem::Space& space() const { return space_; }
  [[nodiscard]] const fem::Operators& operators() const { return operators_; }
  [[nodiscard]] const fem::DirichletDofs& clamped() const { return clamped_; }
  /// Solver of the latest step; other lengths solve by the same method. Valid until the next step.
  [[nodiscard]] const SolverChoice& solver() const { return *lengths_->latest().solver; }
  /// Operators and solver of a step length; valid until the next step. Collective.
  [[nodiscard]] const StepOperators::PerStepLength& of_length(double tau) const { return lengths_->at(tau); }
  /// Number of factorisations so far, repeated ones included.
  [[nodiscard]] int factorisations() const { return lengths_->made(); }
  /// Total time of the factorisations, s.
  [[nodiscard]] double factorisation_seconds() const { return lengths_->seconds(); }
  [[nodiscard]] scene::ContactScheme contact_scheme() const { return contact_scheme_; }
  /// The mass matrix M of this run: the body's, or with massless contact EᵀME (docs/method.md section 2).
  [[nodiscard]] Mat M() const { return redistributed_mass_ ? redistributed_mass_ : operators_.M; }
  /// The projection of the predictor; null except in contact-stabilized stepping.
  [[nodiscard]] const PredictorProjection* predictor() const { return predictor_ ? &*predictor_ : nullptr; }
  /// The moving clamps; null where no clamp moves.
  [[nodiscard]] const MovingClamps* motion() const { return motion_ ? &*motion_ : nullptr; }
  /// The contact candidates; null without contact.
  [[nodiscard]] const contact::ContactPairs* pairs() const { return pairs_ ? &*pairs_ : nullptr; }

  /// The least time in which a pressure wave crosses an element in contact, or under a load that varies, s.
  [[nodiscard]] double wave_time() const { return wave_time_; }

  /// Number of rows of constraints, 0 without contact.
  [[nodiscard]] std::size_t rows() const {
    return pairs_ ? static_cast<std::size_t>(pairs_->rows().count()) : 0;
  }
  /// A contact state without contact.
  [[nodiscard]] contact::ContactState contact_state() const {
    return pairs_ ? contact::ContactState(pairs_->count(), pairs_->rows().count()) : contact::ContactState();
  }
  /// A zero state. Collective.
  [[nodiscard]] State state() const { return {space_.vector(), state_parts()}; }
  /// The number of a state's parts.
  [[nodiscard]] static std::size_t state_parts() { return 2; }
  [[nodiscard]] AdjointState adjoint_state() const { return AdjointState(space_.vector()); }

  /// Memory that the scheme needs beyond that of contact-implicit stepping, bytes. Collective.
  [[nodiscard]] double scheme_bytes() const;

  /// Scratch of steps; one step at a time may use it. No step depends on what an earlier one left in
  /// it.
  struct Workspace {
    petsc::Vector r{}, work{}, moved{};
    double tau = 0; ///< length of the step that `contact` was last used for, s
    std::optional<contact::ContactPairs::Gaps> gaps{};
    std::optional<contact::Workspace> contact{};
    std::optional<PredictorProjection::Workspace> predictor{};
    std::optional<MovingClamps::At> motion{};
  };
  /// Collective.
  [[nodiscard]] Workspace workspace() const;

  /// Makes a step, with obstacles where they are at t_k. Allocates nothing, except within PETSc in VIs that
  /// PETSc solves and with MUMPS. Collective. Throws UserError, SolverFailure.
  void step(const StepInput& in, const StepOutput& out, Workspace& work) const;

  /// The step linearised on the active set of `contact` (docs/method.md section 4). Collective.
  void linearised_step(const LinearisedStep& step, const contact::ContactLinearisation& contact,
                       Workspace& work) const;

  /// The one-sided derivative of the step: as linearised_step(), but weakly active candidates may open, x·ν ≤
  /// 0 there in place of 0 (docs/method.md section 4). On return the active set of `contact` is the set C
  /// that stays closed, on which linearised_step() gives the same. Collective. Throws SolverFailure.
  void one_sided_step(const LinearisedStep& step, contact::ContactLinearisation& contact,
                      Workspace& work) const;

  /// The transpose of linearised_step (4.40)–(4.41), by the formula at Scheme: p_k, and ω_k with M ω_k the
  /// derivative by v_k of the part of J after t_k. Both are zero at k = N + 1. The dual of step k's nodal
  /// force is Scheme::impulse() p_k. Returns the jump of s_{k+1}, null without one. Collective.
  Vec adjoint_step(const AdjointStep& step, Workspace& work) const;

  /// Ends the transpose, with `step` for k = 0: sets ω_0 and, in place of p_0, the derivative of J by y_0, a
  /// functional on the free dofs. Returns the jump of s_1, null without one. Collective.
  Vec adjoint_start(const AdjointStep& step, Workspace& work) const;

private:
  /// Removes the mass from contact nodes, and sets redistributed_mass_.
  void move_mass(const scene::Scene& scene);
  /// Sets work.r = R x + a M z + b source on the free dofs, zero on the clamped ones; for steps and adjoints.
  void right_hand_side(Mat R, Vec x, double a, Vec z, double b, Functional source, Workspace& work) const;
  /// Sets work.r of a linearised step; returns the predictor's jump, null without one.
  Vec linearised_right_hand_side(const LinearisedStep& step, const contact::ContactLinearisation& contact,
                                 Workspace& work) const;
  /// The contact solver of a length, its scratch reset if that was of another; null without contact.
  const contact::ContactStepSolver* contact_solver(const StepOperators::PerStepLength& with,
                                                   Workspace& work) const;
  enum class Direction { linearised, transposed };
  /// Solves a linearised or transposed step for work.r on the active set of `contact`, with `value` and
  /// `multipliers` as in contact::LinearisedContact.
  void solve_on_active_set(double tau, Direction direction, const contact::ContactLinearisation& contact,
                           std::span<const double> value, Vec x, std::span<double> multipliers,
                           Workspace& work) const;
  /// Sets ω_k of an adjoint step from ω_{k+1}, and work.r = R p_{k+1} + M (rate ω_k − rate_{k+1} ω_{k+1} + j)
  /// + ∂J/∂y_k, without the terms of step k + 1 at N. Returns the jump of s_{k+1}, null without one.
  Vec transposed_right_hand_side(const AdjointStep& step, double rate, Workspace& work) const;
  /// Solves a linearised step whose weakly active candidates may open: min ½ p·Dp − r·p over p·ν = 0 on S,
  /// p·ν ≤ 0 on W. The set that stays closed becomes the active one.
  void solve_one_sided(const Scheme& scheme, contact::ContactLinearisation& contact, Vec p,
                       Workspace& work) const;

  const fem::Space& space_;
  const fem::Operators& operators_;
  scene::ContactScheme contact_scheme_;
  double wave_time_;
  std::optional<StepLengths> step_lengths_;
  double end_, first_length_;
  fem::DirichletDofs clamped_;
  std::optional<MovingClamps> motion_;
  std::optional<contact::ContactPairs> pairs_;
  petsc::Matrix redistributed_mass_;                 ///< symmetric half; null unless contact takes mass
  petsc::Matrix mass_blocks_, redistributed_blocks_; ///< the body's and the redistributed one, in blocks
  std::optional<PredictorProjection> predictor_;
  std::optional<StepOperators> lengths_;
};

} // namespace signorini::step
