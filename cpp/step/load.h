// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "fem/operators.h"
#include "fem/time_profile.h"
#include "step/point_force.h"
#include "step/time_grid.h"
#include <concepts>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace signorini::step {

/// Linear functional on V in two parts, φ ↦ (density, φ) + vector·φ, where (·, ·) is the L2 product. A null
/// part is zero and costs nothing.
struct Functional {
  Vec density = nullptr; ///< nodal values; W times these gives the functional's entries
  Vec vector = nullptr;  ///< entries of the functional
};

/// Force of the loads and the control on the body in step k, f_k + s u_k: a force density, N/m³, and forces
/// on the nodes, N.
struct NodalForce : Functional {};

/// Derivative of a function of a motion's states by one of them, such as ∂J/∂y_k.
struct StateDual : Functional {};

/// Series of functionals over the steps of a motion: forces in the steps k = 1…N, or duals of the states k =
/// 0…N. A state is addressed by the step that leads to it. All members are collective.
template <std::derived_from<Functional> F>
class StepByStep {
public:
  virtual ~StepByStep() = default;
  /// Returns whether any step has a density part; if not, add() leaves sum.density unchanged.
  [[nodiscard]] virtual bool has_density() const = 0;
  /// Returns whether any step has a vector part; if not, add() leaves sum.vector unchanged.
  [[nodiscard]] virtual bool has_vector() const = 0;
  /// Adds the force in `step`, or the dual of the state at its end, to `sum`.
  virtual void add(const TimeStep& step, F sum) const = 0;
  /// Returns how much a force f varies between the times `from` and `to` (s): ∫ |f − f̄| dt over this
  /// interval, where f̄ is the mean of f in it, divided by ∫ |f| dt over the whole motion. Returns 0 if f is
  /// constant, which the default implementation assumes. Collective.
  [[nodiscard]] virtual double variation(double from, double to) const {
    (void)from, (void)to;
    return 0;
  }
};

using Load = StepByStep<NodalForce>;
using StateDuals = StepByStep<StateDual>;

/// Sum of several series of forces or duals, evaluated step by step. Allocates vectors only for the parts
/// (density, vector) that some term has. All members are collective.
template <std::derived_from<Functional> F>
class SumAtStep {
public:
  /// Creates the sum of `terms`; null pointers count as zero. `space` and the
  /// objects that `terms` points to must outlive this object.
  SumAtStep(const fem::Space& space, std::initializer_list<const StepByStep<F>*> terms);
  SumAtStep(const fem::Space& space, const StepByStep<F>& term) : SumAtStep(space, {&term}) {}

  /// Returns the sum at a step; valid until the next call.
  [[nodiscard]] F at(const TimeStep& step) const;
  /// Returns the largest StepByStep::variation() of the terms between two times (s).
  [[nodiscard]] double variation(double from, double to) const;

private:
  std::vector<const StepByStep<F>*> terms_;
  petsc::Vector density_, vector_;
};

using ForceAtStep = SumAtStep<NodalForce>;
using DualAtStep = SumAtStep<StateDual>;

/// Sets out = W density + vector, the entries of `functional` as a vector of V. Collective.
void assemble(Functional functional, const fem::Operators& operators, Vec out);

/// Access to the displacements y_0…y_N of a motion.
class Displacements {
public:
  virtual ~Displacements() = default;
  /// Returns the displacement y_k at the end of `step`; valid until the next call. Collective.
  [[nodiscard]] virtual Vec y(const TimeStep& step) const = 0;
};

/// Body force, weight, tractions, forces at points and forces on obstacles with mass of a scene, each
/// averaged over a step to the tolerance of fem::TimeProfile. A load that does not depend on time is
/// evaluated once.
class SceneLoad final : public Load {
public:
  /// Evaluates the loads that do not depend on time. `M`: mass matrix that gives the weight. If the steps
  /// have the same mass matrix (Stepper::M()), a free body falls without strain. `end`: end of the motion, s.
  /// Collective. The references must outlive this object. Throws UserError.
  /// `contacts`: those whose obstacles with mass have their weight and their forces.
  SceneLoad(const fem::Space& space, Mat M, const scene::Load& scene, double end,
            const std::vector<scene::Contact>& contacts = {});
  SceneLoad(const fem::Space& space, Mat M, const scene::Scene& scene, double end)
      : SceneLoad(space, M, scene.load.value_or(scene::Load()), end, scene.contacts) {}
  /// Whether a scene has any of these loads.
  [[nodiscard]] static bool acts(const scene::Scene& scene);

  [[nodiscard]] bool has_density() const override { return body_.has_value(); }
  [[nodiscard]] bool has_vector() const override { return !forces_.empty() || !points_.empty(); }
  /// Adds the means of all loads over the step to `sum`.
  void add(const TimeStep& step, NodalForce sum) const override;

  /// Returns whether any load depends on time, so that it is evaluated in every step.
  [[nodiscard]] bool depends_on_time() const;
  [[nodiscard]] double variation(double from, double to) const override;
  /// Returns a warning for each load whose time integral misses its tolerance.
  [[nodiscard]] std::vector<Warning> warnings() const;
  /// Returns the memory, on all ranks, of the mass matrices of surfaces with tractions, bytes. Collective.
  [[nodiscard]] double surface_bytes() const;

private:
  /// A load, its nodal values and its contribution to the force in a step. The contribution of a body force
  /// is the nodal values themselves. Other contributions are a matrix times the nodal values: for a traction
  /// the mass matrix of its surface, for the weight M.
  struct Term {
    fem::TimeProfile profile;
    petsc::Vector nodal;
    petsc::Matrix surface{}; ///< mass matrix of a traction's surface; null for other loads
    Mat product = nullptr;   ///< matrix that multiplies `nodal`: `surface` or M; null for a body force
    petsc::Vector force{};   ///< product · nodal
  };
  /// Creates a term, and evaluates it unless it depends on time.
  [[nodiscard]] Term term(const scene::Components& components, const std::string& key) const;
  static void multiply(const Term& term);
  static void add_term(const Term& term, const TimeStep& step, Vec out);
  /// Calls visit(profile) for each load.
  template <class Visit>
  void for_each(Visit&& visit) const;

  const fem::Space& space_;
  double end_; ///< end of the motion, s
  std::optional<Term> body_;
  std::vector<Term> forces_;                              ///< gravity and tractions
  std::vector<std::unique_ptr<const PointForce>> points_; ///< at nodes of the mesh and at virtual nodes
};

} // namespace signorini::step
