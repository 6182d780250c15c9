#pragma once
#include "control/control.h"
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
  /// States by their step, each valid until the next is asked for.
  using StateAt = std::function<Vec(int k)>;

  /// `desired` gives y_d,0…y_d,N, each at any time. The references must outlive this object. Throws UserError.
  Objective(const ControlSpace& controls, const fem::Operators& operators, forward::Scheme scheme,
            StateAt desired, const scene::Objective& scene);

  /// What J takes of a motion as it goes by: ‖y_k − y_d,k‖² of each step (N + 1), zero where it has no weight.
  void observe(int k, Vec y, std::vector<double>& squared_distances) const;

  [[nodiscard]] Value value(const std::vector<double>& squared_distances, const Control& u) const;

  /// ∂J/∂y_k along a motion, asked from k = N to 1, given like a load; valid as long as this object lives.
  [[nodiscard]] forward::Load derivative(StateAt y) const;

  /// ∂²J/∂y_k² δy_k for δy_1…δy_N, likewise.
  [[nodiscard]] forward::Load second_derivative(StateAt dy) const;

  /// The integrals over time less their quadrature, to leading order: −τ²/12 of the change of ½ θ ‖e‖²'s rate (trapezoidal
  /// rule) and, if u_k is that in the middle of step k, +τ²/24 of that of α/2 ‖u‖²'s (midpoint rule).
  [[nodiscard]] double quadrature_error(const std::vector<double>& squared_distances, const Control& u) const;

  /// α: the derivative by the control is α u.
  [[nodiscard]] double alpha() const { return alpha_; }

  /// ‖y − y_d,k‖ in L2 of what is observed.
  [[nodiscard]] double distance(int k, Vec y) const;

  /// y_d,k, valid until the next is asked for.
  [[nodiscard]] Vec desired(int k) const { return desired_(k); }

  /// J's state part is Σ_k ½ weight(k) ‖e_k‖², the trapezoidal rule and what counts of the end: what value and derivatives
  /// share.
  [[nodiscard]] double weight(int k) const { return tracking_weight(k) + terminal_weight(k); }

private:
  [[nodiscard]] double tracking_weight(int k) const;
  [[nodiscard]] double terminal_weight(int k) const;
  double squared_distance(int k, Vec y) const;
  /// weight · L2 product · δ for add(k, weight, density of δ): as density over the whole body, else as force.
  [[nodiscard]] forward::Load dual(std::function<void(int k, double weight, Vec out)> add) const;

  forward::Scheme scheme_;
  int steps_;
  StateAt desired_;
  double tracking_, alpha_, gamma_;
  const ControlSpace& controls_;
  petsc::Matrix own_; ///< the L2 product of what is observed; null for the whole body
  Mat observed_;      ///< own_ or W
  petsc::Vector error_, work_;
};

} // namespace signorini::control
