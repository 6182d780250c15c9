#pragma once
#include "control/control.h"
#include "forward/trajectory.h"

namespace signorini::control {

/// The value of J and its parts (method.md section 3).
struct Value {
  double tracking = 0;     ///< τ/2 Σ ½ (‖e_{k−1}‖² + ‖e_k‖²)
  double terminal = 0;     ///< γ ‖e_N‖²
  double control_cost = 0; ///< α τ/2 Σ ‖u_k‖²
  [[nodiscard]] double total() const { return tracking + terminal + control_cost; }
};

/// J: how far the motion is from the desired one, and what the control costs. All members collective.
class Objective {
public:
  /// `desired` holds y_d,0…y_d,N. The references must outlive this object.
  Objective(const ControlSpace& controls, forward::Scheme scheme, petsc::Series desired, double alpha,
            double gamma);

  [[nodiscard]] Value value(const forward::Trajectory& trajectory, const Control& u) const;

  /// density += d_k with ∂J/∂y_k = W d_k at y_k; k = 1…N.
  void add_derivative(int k, Vec y, Vec density) const;

  /// density += d_k with ∂²J/∂y_k² δ = W d_k.
  void add_second_derivative(int k, Vec delta, Vec density) const;

  /// α: the derivative by the control is α u.
  [[nodiscard]] double alpha() const { return alpha_; }

  /// ‖y − y_d,k‖ in L2.
  [[nodiscard]] double distance(int k, Vec y) const;

private:
  /// J's state part is Σ_k ½ state_weight(k) ‖e_k‖², the trapezoidal rule: what value and derivatives share.
  [[nodiscard]] double tracking_weight(int k) const;
  [[nodiscard]] double terminal_weight(int k) const;
  double squared_distance(int k, Vec y) const;

  forward::Scheme scheme_;
  petsc::Series desired_;
  double alpha_, gamma_;
  const ControlSpace& controls_;
  petsc::Vector error_;
};

} // namespace signorini::control
