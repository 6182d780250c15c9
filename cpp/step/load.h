// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "fem/operators.h"
#include "fem/time_profile.h"
#include "step/time_grid.h"
#include <concepts>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

namespace signorini::step {

/// A functional on V in two parts: φ ↦ (density, φ) + vector·φ. A null part is zero and costs nothing.
struct Functional {
  Vec density = nullptr; ///< nodal values; W times these are the functional's entries
  Vec vector = nullptr;  ///< entries of the functional
};

/// Force on the body in a step, f_k + s u_k: a force density, N/m³, and forces on the nodes, N.
struct NodalForce : Functional {};

/// The derivative of a function of the states with respect to one of them, such as ∂J/∂y_k.
struct StateDual : Functional {};

/// Forces of the steps k = 1…N, or duals of the states k = 0…N, each given by the step that leads to it. All
/// members collective.
template <std::derived_from<Functional> F>
class StepByStep {
public:
  virtual ~StepByStep() = default;
  /// Whether any step has a density, a vector; if none has, add() leaves that part of `sum` unchanged.
  [[nodiscard]] virtual bool has_density() const = 0;
  [[nodiscard]] virtual bool has_vector() const = 0;
  /// Adds the force or dual of a step to `sum`.
  virtual void add(const TimeStep& step, F sum) const = 0;
  /// ∫ |f − f̄| dt between two times (s), f̄ the mean there, over ∫ |f| dt of the motion; 0 if f is constant
  /// or no function of time. Collective.
  [[nodiscard]] virtual double variation(double from, double to) const {
    (void)from, (void)to;
    return 0;
  }
};

using Load = StepByStep<NodalForce>;
using StateDuals = StepByStep<StateDual>;

/// The sum of several such series; it allocates vectors for the parts that they have. All members collective.
template <std::derived_from<Functional> F>
class SumAtStep {
public:
  /// Null terms are zero. The references must outlive this object.
  SumAtStep(const fem::Space& space, std::initializer_list<const StepByStep<F>*> terms);
  SumAtStep(const fem::Space& space, const StepByStep<F>& term) : SumAtStep(space, {&term}) {}

  /// The sum at a step; valid until the next call.
  [[nodiscard]] F at(const TimeStep& step) const;
  /// The largest variation of a term.
  [[nodiscard]] double variation(double from, double to) const;

private:
  std::vector<const StepByStep<F>*> terms_;
  petsc::Vector density_, vector_;
};

using ForceAtStep = SumAtStep<NodalForce>;
using DualAtStep = SumAtStep<StateDual>;

/// out ← W density + vector, the functional as a vector of V. Collective.
void assemble(Functional functional, const fem::Operators& operators, Vec out);

/// Displacements y_0…y_N of a motion.
class Displacements {
public:
  virtual ~Displacements() = default;
  /// y_k at the end of a step, valid until the next call. Collective.
  [[nodiscard]] virtual Vec y(const TimeStep& step) const = 0;
};

/// The body force, the weight and the tractions of a scene, each by its exact mean over a step; evaluated
/// again only if they depend on time.
class SceneLoad final : public Load {
public:
  /// `M`: the mass matrix of gravity; with the same for inertia, a free body falls without strain. `end`: end
  /// of the motion, s. Collective. The references must outlive this object. Throws UserError.
  SceneLoad(const fem::Space& space, Mat M, const scene::Load& scene, double end);

  [[nodiscard]] bool has_density() const override { return body_.has_value(); }
  [[nodiscard]] bool has_vector() const override { return !forces_.empty(); }
  /// Adds the mean of f over the step.
  void add(const TimeStep& step, NodalForce sum) const override;

  /// Whether any load is evaluated in every step.
  [[nodiscard]] bool depends_on_time() const;
  [[nodiscard]] double variation(double from, double to) const override;
  /// Warnings of loads whose means miss their tolerance.
  [[nodiscard]] std::vector<Warning> warnings() const;
  /// Memory of the surfaces' mass matrices, bytes. Collective.
  [[nodiscard]] double surface_bytes() const;

private:
  /// A load, its nodal values, and its contribution: these values for a body force; their product with the
  /// surface's mass matrix for a traction, with M for gravity.
  struct Term {
    fem::TimeProfile profile;
    petsc::Vector nodal;
    petsc::Matrix surface{}; ///< null for a body force and gravity
    Mat product = nullptr;   ///< surface or M; null for a body force
    petsc::Vector force{};   ///< product · nodal
  };
  /// Makes a term, evaluated unless it depends on time.
  [[nodiscard]] Term term(const scene::Components& components, const std::string& key) const;
  static void multiply(const Term& term);
  static void add_term(const Term& term, const TimeStep& step, Vec out);
  /// Calls visit(term) for all.
  template <class Visit>
  void for_each(Visit&& visit) const;

  const fem::Space& space_;
  double end_; ///< end of the motion, s
  std::optional<Term> body_;
  std::vector<Term> forces_; ///< gravity and tractions
};

} // namespace signorini::step
