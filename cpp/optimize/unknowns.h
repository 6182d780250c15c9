// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include <cmath>
#include <concepts>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// Optimisation algorithms for problems that satisfy concepts, independent of PETSc and dolfinx. PETSc's TAO
/// is not used, since it works in the Euclidean product of the coefficients. Its number of iterations
/// therefore grows as the mesh is refined. A change of variables by the root of the mass matrix would help,
/// but is practicable only for a diagonal matrix.
namespace signorini::optimize {

/// Immutable vector with shared ownership, so that the state of a search is cheap to copy.
template <class Vector>
using Shared = std::shared_ptr<const Vector>;

template <class Vector>
Shared<Vector> share(Vector v) {
  return std::make_shared<const Vector>(std::move(v));
}

/// Space of unknowns: vectors of a Hilbert space with simple bounds, such as controls (ControlSpace).
template <class U>
concept Unknowns =
    std::copyable<typename U::Vector> && std::semiregular<typename U::Compact> &&
    // Compact: a vector to be stored in large numbers, perhaps rounded and cheap to copy; results of
    // computations are Vectors.
    std::constructible_from<typename U::Compact, const typename U::Vector&> &&
    std::constructible_from<typename U::Vector, const typename U::Compact&> &&
    requires(const U& unknowns, const typename U::Vector& u, typename U::Vector& w,
             const std::vector<typename U::Vector>& duals, std::vector<typename U::Compact>& list,
             const std::vector<double>& factors, const std::vector<std::vector<double>>& columns) {
      { w.add(1.0, u) };        // w += 1.0 u
      { w.add(factors, list) }; // w += Σ factors_i list_i
      { w.scale(1.0) };
      // list_j = Σ_i columns_ji list_i, each rounded once; the list is then as long as the columns.
      { U::Compact::combine(list, columns) };
      // Product in which gradients are Riesz representatives and lengths are measured.
      { unknowns.inner(u, u) } -> std::convertible_to<double>;
      // The functional inner(u, ·), in the form that pairings() takes: the inverse of the Riesz map.
      { unknowns.dual(u) } -> std::same_as<typename U::Vector>;
      // pairings(dual(v_i), w) gives inner(v_i, w_j) (duals × list), in one pass over the w_j, since such
      // lists are long.
      { unknowns.pairings(duals, list) } -> std::same_as<std::vector<double>>;
      // Returns whether there are bounds; without bounds project() and zero_blocked() change nothing.
      { unknowns.bounded() } -> std::convertible_to<bool>;
      // Projects onto the bounds: the nearest point by inner().
      { unknowns.project(w) };
      // zero_blocked(w, u, d): sets w = 0 where u is at a bound and d points out of it; an orthogonal
      // projection in inner().
      { unknowns.zero_blocked(w, u, u) };
    };

/// Returns a − b.
template <class Vector>
Vector difference(Vector a, const Vector& b) {
  a.add(-1, b);
  return a;
}

template <class Vector>
Vector negative(Vector a) {
  a.scale(-1);
  return a;
}

template <Unknowns U>
double norm(const U& unknowns, const typename U::Vector& u) {
  return std::sqrt(unknowns.inner(u, u));
}

template <Unknowns U>
typename U::Vector projected(const U& unknowns, typename U::Vector u) {
  unknowns.project(u);
  return u;
}

/// Returns the stationarity measure ‖u − P(u − g)‖, where P is the projection onto the bounds; without bounds
/// it is ‖g‖. The measure is zero exactly at stationary points.
template <Unknowns U>
double stationarity(const U& unknowns, const typename U::Vector& u, const typename U::Vector& g) {
  if (!unknowns.bounded())
    return norm(unknowns, g);
  return norm(unknowns, difference(projected(unknowns, difference(u, g)), u));
}

/// Returns the projection of d onto the tangent cone of the bounds at u.
template <Unknowns U>
typename U::Vector tangential(const U& unknowns, const typename U::Vector& u, const typename U::Vector& d) {
  typename U::Vector along = d;
  unknowns.zero_blocked(along, u, d);
  return along;
}

/// Writes or reads a list element by element with `each(element, name)`. The same serialize(archive) of a
/// method both writes and reads its state; an archive takes numbers, lists of numbers and shared vectors by
/// name.
template <class Archive, class T, class Each>
void serialize_list(Archive& archive, const std::string& name, std::vector<T>& list, Each&& each) {
  auto count = static_cast<int>(list.size());
  archive(name + "/count", count);
  list.resize(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < list.size(); ++i)
    each(list[i], name + "/" + std::to_string(i));
}

/// Piecewise smooth function J of unknowns; a problem is also the space of its unknowns.
template <class P>
concept Differentiable = Unknowns<P> && requires(P& problem, const typename P::Vector& u) {
  { problem.value(u) } -> std::convertible_to<double>; // J(u); u becomes the trial. Throws SolverFailure
  { problem.trial_gradient() } -> std::same_as<typename P::Vector>; // Riesz representative at the trial
  { problem.accept() };                                             // the trial becomes the current point
};

template <class P>
concept TwiceDifferentiable = Differentiable<P> && requires(P& problem, const typename P::Vector& d) {
  // H d at the current point, Riesz representative by inner()
  { problem.hessian_product(d) } -> std::same_as<typename P::Vector>;
};

/// Point u with the value of J and its gradient g there.
template <Unknowns U>
struct Iterate {
  typename U::Vector u;
  double objective;
  typename U::Vector g;
};

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Returns J at u, which becomes the problem's trial. Returns nothing if a solver fails; the step to u then
/// counts as too long.
template <Differentiable P>
std::optional<double> attempt(P& problem, const typename P::Vector& u) {
  try {
    return problem.value(u);
  } catch (const SolverFailure&) {
    return std::nullopt;
  }
}

/// Returns u with J and its gradient there; u becomes the problem's trial. Returns nothing if a solver fails
/// or J is not finite.
template <Differentiable P>
std::optional<Iterate<P>> evaluated(P& problem, typename P::Vector u) {
  const double value = attempt(problem, u).value_or(nan);
  if (!std::isfinite(value))
    return std::nullopt;
  return Iterate<P>{std::move(u), value, problem.trial_gradient()};
}

} // namespace signorini::optimize
