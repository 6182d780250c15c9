#pragma once
#include "control/control.h"
#include <memory>
#include <vector>

namespace signorini::control {

/// The value of J and its parts (docs/method.md section 3).
struct Value {
  double tracking = 0;     ///< τ/2 Σ ½ (‖e_{k−1}‖² + ‖e_k‖²)
  double terminal = 0;     ///< γ ‖e_N‖²
  double control_cost = 0; ///< α τ/2 Σ ‖u_k‖²
  [[nodiscard]] double total() const { return tracking + terminal + control_cost; }
};

/// J: how far the motion is from the desired one, over the body, a part of it or a surface, and what the
/// control costs. A term whose weight is zero is not evaluated. All members collective.
class Objective {
public:
  /// `desired` is y_d,0…y_d,N, each asked for at any time. The references must outlive this object. Throws UserError.
  Objective(const ControlSpace& controls, const fem::Operators& operators, forward::Scheme scheme,
            std::unique_ptr<const forward::Displacements> desired, const scene::Objective& scene);

  /// What J takes of a motion as it goes by: ‖y_k − y_d,k‖² of each step (N + 1), zero where it has no weight.
  void observe(int k, Vec y, std::vector<double>& squared_distances) const;

  [[nodiscard]] Value value(const std::vector<double>& squared_distances, const Control& u) const;

  /// Whether derivatives by states are densities, else vectors.
  [[nodiscard]] bool observes_whole() const { return !own_; }
  /// Adds ∂J/∂y_k = weight(k) W (y − y_d,k).
  void add_derivative(int k, Vec y, forward::StateDual sum) const;
  /// Adds ∂²J/∂y_k² δy.
  void add_second_derivative(int k, Vec dy, forward::StateDual sum) const;

  /// The integrals over time less their quadrature, to leading order: −τ²/12 of the change of ½ θ ‖e‖²'s rate (trapezoidal
  /// rule) and, if u_k is that in the middle of step k, +τ²/24 of that of α/2 ‖u‖²'s (midpoint rule).
  [[nodiscard]] double quadrature_error(const std::vector<double>& squared_distances, const Control& u) const;

  /// α: the derivative by the control is α u.
  [[nodiscard]] double alpha() const { return alpha_; }

  /// ‖y − y_d,k‖ in L2 of what is observed.
  [[nodiscard]] double distance(int k, Vec y) const;

  /// y_d,k, valid until the next is asked for.
  [[nodiscard]] Vec desired(int k) const { return desired_->y(k); }

  /// J's state part is Σ_k ½ weight(k) ‖e_k‖², the trapezoidal rule and what counts of the end: what value and derivatives
  /// share.
  [[nodiscard]] double weight(int k) const { return tracking_weight(k) + terminal_weight(k); }

private:
  [[nodiscard]] double tracking_weight(int k) const;
  [[nodiscard]] double terminal_weight(int k) const;
  double squared_distance(int k, Vec y) const;
  /// sum += observed_ · density, which is work_.
  void add_observed(forward::StateDual sum) const;

  forward::Scheme scheme_;
  int steps_;
  std::unique_ptr<const forward::Displacements> desired_;
  double tracking_, alpha_, gamma_;
  const ControlSpace& controls_;
  petsc::Matrix own_; ///< the L2 product of what is observed; null for the whole body
  Mat observed_;      ///< own_ or W
  petsc::Vector error_, work_;
};

/// The duals of states that an objective makes of a motion, or of a linearised one; where it has no weight none is asked for.
class ObjectiveDuals : public forward::StateDuals {
public:
  /// The references must outlive this object.
  ObjectiveDuals(const Objective& objective, const forward::Displacements& motion)
      : objective_(objective), motion_(motion) {}
  [[nodiscard]] bool has_density() const override { return objective_.observes_whole(); }
  [[nodiscard]] bool has_vector() const override { return !objective_.observes_whole(); }

protected:
  const Objective& objective_;
  const forward::Displacements& motion_;
};

/// ∂J/∂y_k along a motion.
class Derivative final : public ObjectiveDuals {
public:
  using ObjectiveDuals::ObjectiveDuals;
  void add(int k, forward::StateDual sum) const override {
    if (objective_.weight(k) != 0)
      objective_.add_derivative(k, motion_.y(k), sum);
  }
};

/// ∂²J/∂y_k² δy_k along a linearised one.
class SecondDerivative final : public ObjectiveDuals {
public:
  using ObjectiveDuals::ObjectiveDuals;
  void add(int k, forward::StateDual sum) const override {
    if (objective_.weight(k) != 0)
      objective_.add_second_derivative(k, motion_.y(k), sum);
  }
};

} // namespace signorini::control
