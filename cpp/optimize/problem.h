#pragma once
#include "base/error.h"
#include <cmath>
#include <concepts>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// Optimisation algorithms for a concept, independent of PETSc and dolfinx. PETSc's TAO is not used: it
/// measures with the Euclidean product of the coefficients, whose iterations grow in number as the mesh is
/// refined; the remedy, a change of variables by the root of the mass matrix, exists for diagonal ones only.
namespace signorini::optimize {

/// An immutable vector with several owners, so that the state of a search is cheap to copy.
template <class Vector>
using Shared = std::shared_ptr<const Vector>;

/// A smooth (or piecewise smooth) function on a Hilbert space with simple bounds.
template <class P>
concept BoundedProblem =
    requires(P problem, const typename P::Vector& u, typename P::Vector& w,
             const std::vector<Shared<typename P::Vector>>& list, const std::vector<double>& factors) {
      { problem.value(u) } -> std::convertible_to<double>; // J(u); u becomes the trial
      {
        problem.trial_gradient()
      } -> std::same_as<typename P::Vector>; // there, Riesz representative by inner()
      { problem.accept() };                  // the trial becomes the current point
      { problem.inner(u, u) } -> std::convertible_to<double>;
      { problem.dual(u) } -> std::same_as<typename P::Vector>; // the functional inner(u, ·), for pairings()
      { problem.pairings(u, list) } -> std::same_as<std::vector<double>>; // (dual(v), w): inner(v, w_i)
      { problem.project(w) }; // onto the bounds, in the norm of inner()
      {
        problem.zero_blocked(w, u, u)
      }; // (w, u, d): w = 0 where u is at a bound and d points out of it; self-adjoint in inner()
      { w.add(1.0, u) };
      { w.add(factors, list) }; // w += Σ factors_i list_i
      { w.scale(1.0) };
    };

template <class P>
concept TwiceDifferentiable = BoundedProblem<P> && requires(P problem, const typename P::Vector& d) {
  // H d at the current point, Riesz representative by inner()
  { problem.hessian_product(d) } -> std::same_as<typename P::Vector>;
};

/// Stopping reasons of a search.
enum class Stop { gradient_tolerance, kink, iteration_limit, no_decrease, solver_failed, interrupted };

inline std::string name(Stop stop) {
  switch (stop) {
  case Stop::gradient_tolerance:
    return "gradient norm below tolerance";
  case Stop::kink:
    return "stationary at a kink";
  case Stop::iteration_limit:
    return "iteration limit";
  case Stop::no_decrease:
    return "no further decrease: the predicted one is below rounding (at a minimiser or a kink of J)";
  case Stop::solver_failed:
    return "solver failed in every trial step";
  case Stop::interrupted:
    return "interrupted";
  }
  return "unknown";
}

/// Certificate of stationarity of a piecewise smooth function, kinks included: a short convex combination of
/// gradients gathered within a ball (Goldstein 1977).
template <class Vector>
struct Certificate {
  double length = 0;          ///< of the combination
  double radius = 0;          ///< of the ball around the current point
  std::vector<Vector> points; ///< where the gradients were gathered
  std::vector<double> weights;
};

/// How a search ended.
template <class Vector>
struct Result {
  Stop stop;
  std::optional<Certificate<Vector>> certificate = std::nullopt; ///< at a kink
};

struct Options {
  int max_iterations = 1000;
  double tolerance = 1e-6; ///< of the stationarity measure, relative to the first
};

/// The record of one iteration.
struct Iteration {
  int number = 0;
  double objective = 0;
  double gradient_norm = 0; ///< ‖u − P(u − s g)‖/s with s of the search's Units; without bounds ‖g‖
  /// Multiple taken of the direction; projected-gradient: of the problem's gradient; 0 at the first guess.
  double step_length = 0;

  template <class Archive>
  void serialize(Archive& archive) {
    archive("iteration/number", number);
    archive("iteration/objective", objective);
    archive("iteration/gradient_norm", gradient_norm);
    archive("iteration/step_length", step_length);
  }
};

template <BoundedProblem P>
double norm(const P& problem, const typename P::Vector& u) {
  return std::sqrt(problem.inner(u, u));
}

/// Norm of u − P(u − g), which is zero exactly at stationary points.
template <BoundedProblem P>
double stationarity(const P& problem, const typename P::Vector& u, const typename P::Vector& g) {
  typename P::Vector step = u;
  step.add(-1, g);
  problem.project(step);
  step.add(-1, u);
  return norm(problem, step);
}

/// The projection of d onto the tangent cone of the bounds at u.
template <BoundedProblem P>
typename P::Vector tangential(const P& problem, const typename P::Vector& u, const typename P::Vector& d) {
  typename P::Vector along = d;
  problem.zero_blocked(along, u, d);
  return along;
}

template <class Vector>
Shared<Vector> share(Vector v) {
  return std::make_shared<const Vector>(std::move(v));
}

/// Serialises a list element by element. One serialize(archive) both writes and reads what a method
/// remembers; an archive takes numbers, lists of numbers and shared vectors by name.
template <class Archive, class T, class Each>
void serialize_list(Archive& archive, const std::string& name, std::vector<T>& list, Each&& each) {
  auto count = static_cast<int>(list.size());
  archive(name + "/count", count);
  list.resize(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < list.size(); ++i)
    each(list[i], name + "/" + std::to_string(i));
}

/// Throws SolverFailure if J or its gradient is not finite.
inline void require_finite(const Iteration& iteration) {
  if (!std::isfinite(iteration.objective) || !std::isfinite(iteration.gradient_norm))
    throw SolverFailure("the objective or its gradient is not finite at iteration " +
                        std::to_string(iteration.number));
}

/// The stopping reason at this iterate, if there is one.
inline std::optional<Stop> ended(const Iteration& iteration, double tolerance, const Options& options) {
  if (!(iteration.gradient_norm > tolerance))
    return Stop::gradient_tolerance;
  if (iteration.number >= options.max_iterations)
    return Stop::iteration_limit;
  return std::nullopt;
}

/// The rounding error of J: a smaller decrease is indistinguishable from none.
inline double rounding(double objective) {
  return 4 * std::numeric_limits<double>::epsilon() * std::abs(objective);
}

} // namespace signorini::optimize
