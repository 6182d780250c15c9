// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "optimize/unknowns.h"
#include <limits>
#include <optional>

namespace signorini::optimize {

/// A piecewise smooth function J of unknowns, whose space the problem is itself.
template <class P>
concept Differentiable = Unknowns<P> && requires(P& problem, const typename P::Vector& u) {
  { problem.value(u) } -> std::convertible_to<double>; // J(u); u becomes the trial. Throws SolverFailure
  { problem.trial_gradient() } -> std::same_as<typename P::Vector>; // there, Riesz representative by inner()
  { problem.accept() };                                             // the trial becomes the current point
};

template <class P>
concept TwiceDifferentiable = Differentiable<P> && requires(P& problem, const typename P::Vector& d) {
  // H d at the current point, Riesz representative by inner()
  { problem.hessian_product(d) } -> std::same_as<typename P::Vector>;
};

/// A point with J and its gradient there.
template <Unknowns U>
struct Iterate {
  typename U::Vector u;
  double objective;
  typename U::Vector g;
};

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// J at u, which becomes the trial; none where a solver fails, which counts as too long a step.
template <Differentiable P>
std::optional<double> attempt(P& problem, const typename P::Vector& u) {
  try {
    return problem.value(u);
  } catch (const SolverFailure&) {
    return std::nullopt;
  }
}

/// J and its gradient at u, which becomes the trial; none where a solver fails or J is not finite.
template <Differentiable P>
std::optional<Iterate<P>> evaluated(P& problem, typename P::Vector u) {
  const double value = attempt(problem, u).value_or(nan);
  if (!std::isfinite(value))
    return std::nullopt;
  return Iterate<P>{std::move(u), value, problem.trial_gradient()};
}

} // namespace signorini::optimize
