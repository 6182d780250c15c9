// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/unknowns.h"
#include <span>

namespace signorini::optimize {

/// The units of a search: a length L of controls and a multiple s of the gradient, in units of a control
/// squared over J. L²/s is then the unit of J, and L/s that of gradients.
struct Units {
  double length = 1; ///< L
  double step = 1;   ///< s

  [[nodiscard]] double objective() const { return length * length / step; }
  [[nodiscard]] double gradient() const { return length / step; }

  template <class Archive>
  void serialize(Archive& archive) {
    archive("units/length", length);
    archive("units/step", step);
  }
};

/// The units of the problem at its current point u: L is the length of Cauchy's step, which minimises J's
/// quadratic model along steepest descent (by one Hessian product), after projection onto the bounds; s is
/// the multiple of the gradient of that length. They depend on u, J and the bounds, not on the mesh, and
/// scale with the units of u and J. The first guess enters by J's derivatives there alone: the origin of
/// controls has no influence.
///
/// The Hessian may be singular. A J that is a sum of squares, as with frozen active sets, still has curvature
/// along its gradient, and the step is at most 2 J/‖g‖² times the gradient; that bound is taken where no
/// curvature is found.
template <TwiceDifferentiable P>
[[nodiscard]] Units measured(P& problem, const typename P::Vector& u, double objective,
                             const typename P::Vector& g) {
  const typename P::Vector d = tangential(problem, u, negative(g));
  const double squared = problem.inner(d, d);
  if (squared == 0)
    return {}; // stationary: units do not matter
  const double curvature = problem.inner(d, problem.hessian_product(d));
  typename P::Vector step = u;
  step.add(curvature > 0 ? squared / curvature : 2 * std::abs(objective) / squared, d);
  const double length = norm(problem, difference(projected(problem, std::move(step)), u));
  // Otherwise J is linear and zero, and defines no units.
  return std::isfinite(length) && length > 0 ? Units{length, length / std::sqrt(squared)} : Units();
}

/// The problem in dimensionless form, so that no method depends on its units: a control of length L, a
/// curvature of 1/s and a J of L²/s become one. Controls and their bounds are unchanged; products are divided
/// by L², J by L²/s, and gradients are multiplied by s, which gives them the length of a step.
template <TwiceDifferentiable P>
class Dimensionless {
public:
  using Vector = typename P::Vector;
  using Compact = typename P::Compact;

  explicit Dimensionless(P& problem) : problem_(problem) {}

  void measure_in(const Units& units) { units_ = units; }
  [[nodiscard]] const Units& units() const { return units_; }

  double value(const Vector& u) { return problem_.value(u) / units_.objective(); }
  Vector trial_gradient() { return stepped(problem_.trial_gradient()); }
  Vector hessian_product(const Vector& d) { return stepped(problem_.hessian_product(d)); }
  void accept() { problem_.accept(); }
  [[nodiscard]] double inner(const Vector& u, const Vector& w) const {
    return problem_.inner(u, w) / squared_length();
  }
  [[nodiscard]] Vector dual(const Vector& u) const { return problem_.dual(u); }
  [[nodiscard]] std::vector<double> pairings(std::span<const Vector> duals,
                                             std::span<const Compact> w) const {
    std::vector<double> products = problem_.pairings(duals, w);
    for (double& product : products)
      product /= squared_length();
    return products;
  }
  [[nodiscard]] bool bounded() const { return problem_.bounded(); }
  void project(Vector& u) const { problem_.project(u); }
  void zero_blocked(Vector& w, const Vector& u, const Vector& d) const { problem_.zero_blocked(w, u, d); }

  /// Converts a gradient or Hessian product of the problem.
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
