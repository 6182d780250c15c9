// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control_space.h"
#include <memory>
#include <vector>

namespace signorini::control {

/// Value of J and its parts (docs/method.md section 3).
struct ObjectiveValue {
  double tracking = 0;     ///< θ τ/2 Σ ½ (‖e_{k−1}‖² + ‖e_k‖²)
  double terminal = 0;     ///< γ ‖e_N‖²
  double control_cost = 0; ///< α τ/2 Σ ‖u_k‖²
  double misfit = 0;       ///< half the sum of squared residuals of measurements and priors
  [[nodiscard]] double total() const { return tracking + terminal + control_cost + misfit; }
};

/// Weights of the terms of J at the times t_k (docs/method.md section 3).
class TimeWeights {
public:
  TimeWeights(const scene::Objective& scene, step::TimeGrid grid);

  [[nodiscard]] const step::TimeGrid& grid() const { return grid_; }
  /// Returns the weight θ of the tracking term.
  [[nodiscard]] double tracking() const { return tracking_; }
  /// Returns the weight α of the control cost; the derivative of that cost by the control is α u.
  [[nodiscard]] double alpha() const { return alpha_; }
  /// Returns the weight w_k of ½ ‖e_k‖²: the tracking and terminal terms of J together are Σ_k ½ w_k ‖e_k‖².
  [[nodiscard]] double of(int k) const { return tracking_at(k) + terminal_at(k); }
  /// Computes J from the squared distances ‖e_k‖² (N + 1) and the control u, which is not read if α is zero.
  [[nodiscard]] ObjectiveValue value(const std::vector<double>& squared_distances,
                                     const ControlSpace& controls, const Control& u) const;

private:
  [[nodiscard]] double tracking_at(int k) const;
  [[nodiscard]] double terminal_at(int k) const;

  step::TimeGrid grid_;
  double tracking_, alpha_, gamma_;
};

/// Set on which an objective compares motions, with its product: in L2 the body, a part of it or a surface;
/// or an obstacle with mass, with the product of vectors of its translations. All members are collective.
class ObservedSet {
public:
  /// `operators` must outlive this object. Throws UserError.
  ObservedSet(const fem::Space& space, const fem::Operators& operators, const scene::Scene& scene);

  /// Returns whether the set is the whole body.
  [[nodiscard]] bool whole() const { return !own_; }
  /// Returns the matrix of the set's product; W for the whole body.
  [[nodiscard]] Mat product() const { return product_; }
  /// Returns ‖y − other‖² in the norm of the set.
  [[nodiscard]] double squared_distance(Vec y, Vec other) const;
  /// Returns ‖y‖ in the norm of the set.
  [[nodiscard]] double norm(Vec y) const;

private:
  petsc::Matrix own_; ///< matrix of the set's product; null for the whole body
  Mat product_;       ///< own_ or W
  petsc::Vector difference_, work_;
};

/// Objective J (docs/method.md section 3): the distance of a motion from the desired motion, plus the cost of
/// the control. Distances are those of an ObservedSet. A term with zero weight is
/// not evaluated. All members are collective.
class Objective {
public:
  /// `desired`: desired displacements y_d,0…y_d,N, which are read in any order. The references must outlive
  /// this object. Throws UserError.
  Objective(const ControlSpace& controls, const fem::Operators& operators, step::TimeGrid grid,
            std::unique_ptr<const step::Displacements> desired, const scene::Scene& scene);

  /// Stores ‖y_k − y_d,k‖² as entry k of `squared_distances` (N + 1); an entry of zero weight stays zero.
  void observe(int k, Vec y, std::vector<double>& squared_distances) const;

  /// Computes J from the squared distances that observe() stored and the control u.
  [[nodiscard]] ObjectiveValue value(const std::vector<double>& squared_distances, const Control& u) const {
    return weights_.value(squared_distances, controls_, u);
  }

  /// Returns whether derivatives of J by states are densities rather than vectors (step::Functional).
  [[nodiscard]] bool observes_whole() const { return observed_.whole(); }
  /// Adds ∂J/∂y_k = weight(k) W (y − y_d,k) to `sum`.
  void add_derivative(int k, Vec y, step::StateDual sum) const { add_weighted(k, y, desired(k), sum); }
  /// Adds ∂²J/∂y_k² δy, with δy = `dy`, to `sum`.
  void add_second_derivative(int k, Vec dy, step::StateDual sum) const { add_weighted(k, dy, nullptr, sum); }

  /// Returns the error of J's quadrature in time, exact integral minus quadrature, to leading order. The
  /// trapezoidal rule of the tracking term contributes −Σ_k τ_k²/12 times the change of d/dt ½ θ ‖e‖² over
  /// step k. A control with values for each step contributes +Σ_k τ_k²/12 ∫ α/2 ‖u'‖² dt over step k, u_k
  /// being the mean over that step. Zero for fewer than three steps.
  [[nodiscard]] double quadrature_error(const std::vector<double>& squared_distances, const Control& u) const;

  /// Returns the weight α of the control cost; the derivative of that cost by the control is α u.
  [[nodiscard]] double alpha() const { return weights_.alpha(); }

  /// Returns the distance ‖y − y_d,k‖ in the norm of the observed set.
  [[nodiscard]] double distance(int k, Vec y) const;

  /// Returns the norm ‖y‖ in the norm of the observed set.
  [[nodiscard]] double norm(Vec y) const { return observed_.norm(y); }

  /// Returns the desired displacement y_d,k; valid until the next call.
  [[nodiscard]] Vec desired(int k) const { return desired_->y(weights_.grid().step(k)); }

  /// Returns the weight w_k of ½ ‖y_k − y_d,k‖² in J (docs/method.md section 3).
  [[nodiscard]] double weight(int k) const { return weights_.of(k); }

private:
  /// Returns Σ_k τ_k² ∫ ‖u'‖² dt, the integral being over step k.
  [[nodiscard]] double variation(const Control& u) const;
  /// Returns ‖y − y_d,k‖² in the norm of the observed set.
  double squared_distance(int k, Vec y) const;
  /// Adds weight(k) W (y − less) to `sum`; a null `less` counts as zero.
  void add_weighted(int k, Vec y, Vec less, step::StateDual sum) const;

  TimeWeights weights_;
  std::unique_ptr<const step::Displacements> desired_;
  const ControlSpace& controls_;
  ObservedSet observed_;
  petsc::Vector work_;
};

/// Derivatives ∂J/∂y_k along a motion or, with Order::second, ∂²J/∂y_k² δy_k along a linearised motion.
/// States of zero weight are not read.
class ObjectiveDuals final : public step::StateDuals {
public:
  enum class Order { first, second };

  /// The references must outlive this object.
  ObjectiveDuals(const Objective& objective, const step::Displacements& motion, Order order = Order::first)
      : objective_(objective), motion_(motion), order_(order) {}
  [[nodiscard]] bool has_density() const override { return objective_.observes_whole(); }
  [[nodiscard]] bool has_vector() const override { return !objective_.observes_whole(); }
  void add(const step::TimeStep& step, step::StateDual sum) const override {
    if (objective_.weight(step.k) == 0)
      return;
    if (order_ == Order::first)
      objective_.add_derivative(step.k, motion_.y(step), sum);
    else
      objective_.add_second_derivative(step.k, motion_.y(step), sum);
  }

private:
  const Objective& objective_;
  const step::Displacements& motion_;
  Order order_;
};

} // namespace signorini::control
