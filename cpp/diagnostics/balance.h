// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "trajectory/time_integrator.h"
#include <array>
#include <cmath>
#include <string>

namespace signorini::diagnostics {

struct BodyFigures;

/// Returns the Euclidean norm of x.
[[nodiscard]] inline double length(const std::array<double, 3>& x) { return std::hypot(x[0], x[1], x[2]); }

/// Energy and momentum balance of one step, from the exact discrete identities of docs/method.md section 2.
/// Energies are in J, forces in N; in plane strain and plane stress per metre of depth, J/m and N/m.
struct StepBalance {
  double kinetic_energy = 0;      ///< ½ v·Mv at the end of the step
  double elastic_energy = 0;      ///< ½ y·Ay at the end of the step, without the foundations' part of A
  double viscous_dissipation = 0; ///< τ w·Bw of the step, w = (y_k − y_{k−1})/τ, by the material's part of B
  double foundation_energy = 0;   ///< ½ y·Ay at the end of the step, by the foundations' part of A
  double foundation_dissipation = 0; ///< τ w·Bw of the step, by the foundations' part of B
  double drag_dissipation = 0;       ///< τ w·Bw of the step, by the mass-proportional part of B
  double relaxation_energy = 0;      ///< ½ Σ q_j·A_j q_j at the end of the step, over the branches
  double relaxation_dissipation = 0; ///< Σ τ/t_j q̄_j·A_j q̄_j of the step, q̄_j = (q_j,k−1 + q_j,k)/2
  double rigid_energy = 0;           ///< of obstacles with mass and of their springs, at the end of the step
  double rigid_dissipation = 0;      ///< τ w·Bw of the step, by the dashpots of obstacles with mass
  double external_work = 0;          ///< work of loads and control, f·(y_k − y_{k−1}), and of moving clamps
  double load_work = 0;              ///< work of the scene's loads alone
  double contact_work = 0;           ///< F_k·(y_k − y_{k−1}); never positive if obstacles are at rest
  double friction_work = 0;          ///< part of contact_work, −(2/τ²) σ·w with the slips w; never positive
  double belt_work = 0; ///< part of contact_work by the obstacles' motion along their surface, −(2/τ²) σ·ds
  double energy_residual = 0;                ///< residual of the energy identity
  std::array<double, 3> contact_force{};     ///< resultant of the contact forces on the body
  std::array<double, 3> momentum{};          ///< momentum at the end of the step, kg m/s
  std::array<double, 3> momentum_residual{}; ///< rate of momentum minus loads, contact forces and reactions
                                             ///< of clamps and surroundings
  /// Returns the energy of the body, with its branches, of its foundations and of obstacles with mass at the
  /// end of the step.
  [[nodiscard]] double energy() const {
    return kinetic_energy + elastic_energy + foundation_energy + relaxation_energy + rigid_energy;
  }
  double momentum_scale =
      0; ///< sum of the moduli of the terms of the momentum balance, for judging the residual
};

/// Computes the balances of a motion frame by frame, from frame 0 on. The balance of frame 0 contains only
/// the initial energies and momentum.
class Balance {
public:
  /// Optional parts of a balance.
  struct Wanted {
    bool reactions = false;    ///< whether to compute the reactions of the clamps
    bool other_forces = false; ///< whether forces other than the scene's loads act
    /// The scene's loads; read only if `other_forces`; null if it has none.
    const step::Load* loads = nullptr;
  };

  /// Prepares the balances of motions of `stepper`. Collective. The references must outlive this object.
  explicit Balance(const step::Stepper& stepper, Wanted wanted);
  explicit Balance(const step::Stepper& stepper) : Balance(stepper, Wanted{}) {}

  /// Returns the balance of the next frame; frames are passed in order, from frame 0 on. Allocates nothing.
  /// Collective.
  StepBalance operator()(const trajectory::Frame& frame);

  /// Momenta M v and elastic forces A y of the nodes in the last frame, vectors of V.
  [[nodiscard]] Vec momenta() const { return Mv1_; }
  [[nodiscard]] Vec elastic_forces() const { return Ay1_; }

  /// Returns the forces of the clamps on the body in the last frame's step, on the clamped dofs; entries of
  /// other dofs have no meaning. Null unless Wanted::reactions is set; zero in frame 0.
  [[nodiscard]] Vec reactions() const { return reactions_ ? Vec(defect_) : nullptr; }

private:
  struct Sums;
  /// Forces of the branches of materials that relax.
  struct Branches {
    petsc::Series forces;      ///< A_j q_j at the end of the last frame's step
    petsc::Vector mean;        ///< Σ A_j q̄_j of that step
    petsc::Vector shear, bulk; ///< products of K_s and K_b of one material with w; zero if the matrix is null
  };
  /// Adds the terms of the state at the end of the frame's step to `sums`. Collective.
  void add_state(const trajectory::Frame& frame, Sums& sums);
  /// Adds the terms of the frame's step to `sums`. Returns the work of the scene's loads alone, without the
  /// control. Collective.
  double add_step(const trajectory::Frame& frame, Sums& sums);
  /// Sets the forces of the branches in the frame's step, and adds their energy and dissipation to `sums`.
  /// w_ must be (y_k − y_{k−1})/τ. Collective.
  void add_branches(const trajectory::Frame& frame, Sums& sums);
  /// Sets the works of friction in the frame's step.
  void add_friction(const trajectory::Frame& frame, StepBalance& now);
  /// Adds the forces and the dissipation of foundations and drag in the last frame's step to `sums`.
  /// Collective.
  void add_surroundings(Sums& sums);

  const step::Stepper& stepper_;
  bool reactions_;
  petsc::Vector Ay0_, Ay1_, Mv0_, Mv1_, Bw_, w_, load_, force_, defect_;
  std::optional<step::ForceAtStep> loads_alone_;
  petsc::Vector foundation0_, foundation1_, dashpots_, drag_; ///< parts of Ay0_, Ay1_ and Bw_
  std::optional<Branches> branches_;                          ///< absent unless a material relaxes
  std::vector<double> ways_; ///< ways of the obstacles along their surfaces (rows), m; empty without friction
  double energy_ = 0;        ///< energy of the last frame
};

/// Monitors the exact laws of the scheme step by step (docs/method.md section 2). Defects are relative: to
/// the largest quantity of their kind in the run so far, or in the case of penetration to the body's
/// diameter. At the first touch there is no earlier contact force. Therefore contact forces are compared with
/// at least the force of an impact with the run's largest energy: the momentum of the body at this energy,
/// divided by the time in which a wave crosses the body.
class Invariants {
public:
  /// Relative defect of one law.
  struct Defect {
    const char* name;
    double worst = 0; ///< largest defect of the steps so far
    int step = 0;     ///< number of the step with that defect
  };

  /// Creates the monitor of motions of `stepper`. Collective. `stepper` must outlive this object.
  Invariants(const step::Stepper& stepper, const BodyFigures& body);

  /// Updates the defects by the next frame and its balance; frames are passed in order, from frame 0 on.
  /// Collective.
  void observe(const trajectory::Frame& frame, const StepBalance& balance);

  /// Returns the defects of energy law and momentum law; with contact also those of penetration, adhesion and
  /// complementarity, with friction that of the friction law.
  [[nodiscard]] std::span<const Defect> defects() const {
    return {defects_.data(), stepper_.frictional() ? defects_.size() : stepper_.pairs() ? 5 : 2};
  }

  /// Returns a text on the worst defect of the last frame if that defect is above `tolerance`.
  [[nodiscard]] std::optional<std::string> violation(double tolerance) const;

  /// Returns the relative momentum defect of the last frame.
  [[nodiscard]] double momentum() const { return now_[1]; }
  /// Returns the largest of the last frame's relative contact defects: penetration, adhesion,
  /// complementarity and Coulomb's law.
  [[nodiscard]] double complementarity() const;

  /// Returns the largest energy of the run so far, in the unit of StepBalance.
  [[nodiscard]] double largest_energy() const { return energy_; }

private:
  /// Returns the defect of the friction law: the largest friction force above its bound, and the largest
  /// difference of the friction's work from −bound times slip; `scale`: N.
  [[nodiscard]] double friction_defect(const contact::ContactState& state, double unit, double scale) const;

  const step::Stepper& stepper_;
  double stiffness_;       ///< largest diagonal entry of A + Σ A_j, an estimate of the norm
  double mass_, crossing_; ///< mass of the body, kg or kg/m of depth; crossing time of a wave, s
  double energy_ = 0, forces_ = 0, contact_force_ = 0;
  std::array<Defect, 6> defects_{{{"energy law, residual beyond rounding / largest energy"},
                                  {"momentum law, residual / largest forces"},
                                  {"penetration / diameter"},
                                  {"adhesion / force scale"},
                                  {"force x gap / (force scale x diameter)"},
                                  {"friction law, defect of force and work / scales"}}};
  std::array<double, 6> now_{};
};

} // namespace signorini::diagnostics
