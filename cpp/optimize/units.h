#pragma once
#include "optimize/problem.h"
#include <span>

namespace signorini::optimize {

/// What a search measures in: a length L of controls and a multiple s of the gradient, whose units are those of a
/// control squared over J. L²/s is then one of J, and L/s one of gradients.
struct Units {
  double length = 1; ///< L
  double step = 1;   ///< s

  [[nodiscard]] double objective() const { return length * length / step; }
  [[nodiscard]] double gradient() const { return length / step; }

  template <class Archive>
  void exchange(Archive& archive) {
    archive("units/length", length);
    archive("units/step", step);
  }
};

/// Those of the problem itself at its current point u: L is how far the bounds let the step lead that ends at the least
/// value of J's quadratic model along the steepest descent (Cauchy's, by one Hessian product), and s the multiple of the
/// gradient that is as long. They are functions of u, J and the bounds, not of the mesh, and with other units of u or J
/// they change as those do. A first guess enters by J's derivatives there alone: where zero is means nothing to J.
///
/// The Hessian may be singular: a J that is a sum of squares, as that of a motion with frozen contact, curves along its
/// gradient all the same, and the step is at most 2 J/‖g‖² times the gradient. That it is where no curvature is to be seen.
template <TwiceDifferentiable P>
[[nodiscard]] Units measured(P& problem, const typename P::Vector& u, double objective, const typename P::Vector& g) {
  typename P::Vector down = g;
  down.scale(-1);
  const typename P::Vector d = tangential(problem, u, down);
  const double squared = problem.inner(d, d);
  if (squared == 0)
    return {}; // stationary: nothing will be measured
  const double curvature = problem.inner(d, problem.hessian_product(d));
  typename P::Vector step = u;
  step.add(curvature > 0 ? squared / curvature : 2 * std::abs(objective) / squared, d);
  problem.project(step);
  step.add(-1, u);
  const double length = norm(problem, step);
  // Where it is not, J is linear and zero, and has no units of its own.
  return std::isfinite(length) && length > 0 ? Units{length, length / std::sqrt(squared)} : Units();
}

/// A problem in its units, so that no method knows of any other: a control of the length L, a curvature of 1/s and a J
/// of L²/s are one. Controls themselves stay as they are, and so do their bounds; products are divided by L², J by
/// L²/s, and a gradient becomes s times that of the problem: as long as a step.
template <TwiceDifferentiable P>
class Dimensionless {
public:
  using Vector = typename P::Vector;

  explicit Dimensionless(P& problem) : problem_(problem) {}

  void measure_in(const Units& units) { units_ = units; }
  [[nodiscard]] const Units& units() const { return units_; }

  double value(const Vector& u) { return problem_.value(u) / units_.objective(); }
  Vector trial_gradient() { return stepped(problem_.trial_gradient()); }
  Vector hessian_product(const Vector& d) { return stepped(problem_.hessian_product(d)); }
  void accept() { problem_.accept(); }
  [[nodiscard]] double inner(const Vector& u, const Vector& w) const { return problem_.inner(u, w) / squared_length(); }
  [[nodiscard]] Vector dual(const Vector& u) const { return problem_.dual(u); }
  [[nodiscard]] std::vector<double> pairings(const Vector& dual, std::span<const Shared<Vector>> w) const {
    std::vector<double> products = problem_.pairings(dual, w);
    for (double& product : products)
      product /= squared_length();
    return products;
  }
  void project(Vector& u) const { problem_.project(u); }
  void hold(Vector& w, const Vector& u, const Vector& d) const { problem_.hold(w, u, d); }

  /// From a gradient of the problem.
  [[nodiscard]] Vector stepped(Vector g) const {
    g.scale(units_.step);
    return g;
  }

private:
  [[nodiscard]] double squared_length() const { return units_.length * units_.length; }

  P& problem_;
  Units units_;
};

} // namespace signorini::optimize
