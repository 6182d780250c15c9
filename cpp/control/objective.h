// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control_space.h"
#include <memory>
#include <vector>

namespace signorini::control {

/// The value of J and its parts (docs/method.md section 3).
struct ObjectiveValue {
  double tracking = 0;     ///< θ τ/2 Σ ½ (‖e_{k−1}‖² + ‖e_k‖²)
  double terminal = 0;     ///< γ ‖e_N‖²
  double control_cost = 0; ///< α τ/2 Σ ‖u_k‖²
  double misfit = 0;       ///< ½ Σ of squared residuals of measurements and priors
  [[nodiscard]] double total() const { return tracking + terminal + control_cost + misfit; }
};

/// The weights of the terms of J in time (docs/method.md section 3).
class TimeWeights {
public:
  TimeWeights(const scene::Objective& scene, step::TimeGrid grid);

  [[nodiscard]] const step::TimeGrid& grid() const { return grid_; }
  /// Weight θ of the tracking term.
  [[nodiscard]] double tracking() const { return tracking_; }
  /// Weight α of the control cost; the derivative by the control is α u.
  [[nodiscard]] double alpha() const { return alpha_; }
  /// Weight w_k: the state part of J is Σ_k ½ w_k ‖e_k‖², tracking and terminal term.
  [[nodiscard]] double of(int k) const { return tracking_at(k) + terminal_at(k); }
  /// Computes J from the ‖e_k‖² (N + 1) and the control u, which is not read where α is zero.
  [[nodiscard]] ObjectiveValue value(const std::vector<double>& squared_distances,
                                     const ControlSpace& controls, const Control& u) const;

private:
  [[nodiscard]] double tracking_at(int k) const;
  [[nodiscard]] double terminal_at(int k) const;

  step::TimeGrid grid_;
  double tracking_, alpha_, gamma_;
};

/// The set on which an objective compares motions, with its product in L2: the body, a part of it or a
/// surface. All members collective.
class ObservedSet {
public:
  /// `operators` must outlive this object. Throws UserError.
  ObservedSet(const fem::Space& space, const fem::Operators& operators, const scene::Objective& scene);

  [[nodiscard]] bool whole() const { return !own_; }
  /// The matrix of the product: W for the whole body.
  [[nodiscard]] Mat product() const { return product_; }
  [[nodiscard]] double squared_distance(Vec y, Vec other) const;
  [[nodiscard]] double norm(Vec y) const;

private:
  petsc::Matrix own_; ///< null for the whole body
  Mat product_;       ///< own_ or W
  petsc::Vector difference_, work_;
};

/// The objective J (docs/method.md section 3): the distance of the motion from the desired one, and the cost
/// of the control. Distances are those in L2 of the body, a part of it or a surface. A term whose weight is
/// zero is not evaluated. All members collective.
class Objective {
public:
  /// `desired` is y_d,0…y_d,N, read in any order. The references must outlive this object. Throws UserError.
  Objective(const ControlSpace& controls, const fem::Operators& operators, step::TimeGrid grid,
            std::unique_ptr<const step::Displacements> desired, const scene::Objective& scene);

  /// Stores ‖y_k − y_d,k‖² as entry k of `squared_distances` (N + 1); an entry without weight stays zero.
  void observe(int k, Vec y, std::vector<double>& squared_distances) const;

  /// Computes J from the squared distances of observe().
  [[nodiscard]] ObjectiveValue value(const std::vector<double>& squared_distances, const Control& u) const {
    return weights_.value(squared_distances, controls_, u);
  }

  /// Whether derivatives by states are densities, else vectors (step::Functional).
  [[nodiscard]] bool observes_whole() const { return observed_.whole(); }
  /// Adds ∂J/∂y_k = weight(k) W (y − y_d,k).
  void add_derivative(int k, Vec y, step::StateDual sum) const { add_weighted(k, y, desired(k), sum); }
  /// Adds ∂²J/∂y_k² δy.
  void add_second_derivative(int k, Vec dy, step::StateDual sum) const { add_weighted(k, dy, nullptr, sum); }

  /// The time integrals of J less their quadrature, to leading order. The trapezoidal rule contributes
  /// −τ_k²/12 times the change of d/dt ½ θ ‖e‖² over step k, summed. A control that varies in time
  /// contributes +τ_k²/12 ∫ α/2 ‖u'‖² dt (u_k being the mean over step k). Zero for fewer than three steps.
  [[nodiscard]] double quadrature_error(const std::vector<double>& squared_distances, const Control& u) const;

  /// Weight α of the control cost; the derivative by the control is α u.
  [[nodiscard]] double alpha() const { return weights_.alpha(); }

  /// Distance ‖y − y_d,k‖ in L2 of the set that is observed.
  [[nodiscard]] double distance(int k, Vec y) const;

  /// Norm ‖y‖ in L2 of the set that is observed.
  [[nodiscard]] double norm(Vec y) const { return observed_.norm(y); }

  /// Desired displacement y_d,k, valid until the next call.
  [[nodiscard]] Vec desired(int k) const { return desired_->y(weights_.grid().step(k)); }

  /// Weight w_k of docs/method.md section 3.
  [[nodiscard]] double weight(int k) const { return weights_.of(k); }

private:
  /// Computes Σ_k τ_k² ∫ ‖u'‖² dt over step k.
  [[nodiscard]] double variation(const Control& u) const;
  double squared_distance(int k, Vec y) const;
  /// Adds weight(k) W (y − less); a null `less` is zero.
  void add_weighted(int k, Vec y, Vec less, step::StateDual sum) const;

  TimeWeights weights_;
  std::unique_ptr<const step::Displacements> desired_;
  const ControlSpace& controls_;
  ObservedSet observed_;
  petsc::Vector work_;
};

/// Derivatives ∂J/∂y_k along a motion, or ∂²J/∂y_k² δy_k along a linearised one. States without weight are
/// not read.
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
