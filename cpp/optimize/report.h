// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/unknowns.h"
#include <algorithm>
#include <string>

namespace signorini::optimize {

/// Certificate of stationarity of a piecewise smooth function, kinks included: a short convex combination of
/// gradients gathered within a ball (Goldstein 1977).
template <class Vector>
struct Certificate {
  double length = 0;                  ///< length of the combination
  double radius = 0;                  ///< radius of the ball around the current point
  std::vector<Shared<Vector>> points; ///< points at which the gradients were gathered
  std::vector<double> weights;        ///< weights of the gradients; their sum is 1

  template <class Archive>
  void serialize(Archive& archive, const std::string& name) {
    archive(name + "/length", length);
    archive(name + "/radius", radius);
    serialize_list(archive, name + "/points", points,
                   [&](Shared<Vector>& u, const std::string& number) { archive(number, u); });
    archive(name + "/weights", weights);
  }
};

/// Gradients gathered around a point and their convex combination. This is a certificate if it is short and
/// the points are near enough.
template <Differentiable P>
struct GatheredGradients {
  using Vector = typename P::Vector;

  Certificate<Vector> certificate{};
  Vector sum;           ///< convex combination of the gradients
  bool complete = true; ///< whether J could be evaluated at all points

  /// Returns whether J was evaluated at all points, all points are within the radius `ball`, and the
  /// combination is at most `length` long.
  [[nodiscard]] bool confirms(double length, double ball) const {
    return complete && certificate.length <= length && certificate.radius <= ball;
  }
};

/// Gathers the gradients of a convex combination with these weights. The first weight belongs to the gradient
/// at the current point `at`. For each further weight i that is positive, the gradient g is evaluated at
/// `point(i)` and passed to `each(i, g)`. The length of the returned certificate is the stationarity measure
/// of the combination at `at`. It includes values that a method blocks, and does not depend on a model of J.
template <Differentiable P, class PointOf, class Each>
GatheredGradients<P> gather(P& problem, const Iterate<P>& at, const std::vector<double>& weights,
                            PointOf&& point, Each&& each) {
  GatheredGradients<P> all{.sum = at.g};
  auto& [length, radius, points, positive] = all.certificate;
  all.sum.scale(weights.front());
  if (weights.front() > 0) {
    points.push_back(share(at.u));
    positive.push_back(weights.front());
  }
  for (std::size_t i = 1; i < weights.size(); ++i) {
    if (!(weights[i] > 0))
      continue;
    auto there = evaluated(problem, point(i));
    all.complete = all.complete && there;
    if (!there)
      continue;
    all.sum.add(weights[i], there->g);
    radius = std::max(radius, norm(problem, difference(there->u, at.u)));
    points.push_back(share(std::move(there->u)));
    positive.push_back(weights[i]);
    each(i, std::move(there->g));
  }
  length = stationarity(problem, at.u, all.sum);
  return all;
}

/// Returns whether J is stationary at the convex combination of the certificate's points. It is if all points
/// are on one smooth selection of J, without a kink between them: the gradient at the combination of the
/// points is then the combination of their gradients, which is short.
template <Differentiable P>
bool stationary_between(P& problem, const Certificate<typename P::Vector>& certificate, double tolerance) {
  typename P::Vector u = *certificate.points.front();
  u.scale(certificate.weights.front());
  for (std::size_t i = 1; i < certificate.points.size(); ++i)
    u.add(certificate.weights[i], *certificate.points[i]);
  const auto there = evaluated(problem, projected(problem, std::move(u))); // projected for rounding
  return there && stationarity(problem, there->u, there->g) <= tolerance;
}

/// Stopping reasons of a search.
enum class Stop {
  gradient_tolerance,
  kink,
  iteration_limit,
  no_decrease,
  solver_failed,
  interrupted,
  short_steps,
  enough
};

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
  case Stop::short_steps:
    return "short steps, as among kinks";
  case Stop::enough:
    return "accurate enough";
  }
  return "unknown";
}

/// Result of a search.
template <class Vector>
struct Result {
  Stop stop;
  std::optional<Certificate<Vector>> certificate = std::nullopt; ///< set if the search ended at a kink
  double first_norm = 0; ///< first gradient norm; Options::tolerance is relative to it
};

/// Record of one iteration.
struct Iteration {
  int number = 0;
  double objective = 0;
  double gradient_norm = 0; ///< ‖u − P(u − s g)‖/s with s of the search's SearchUnits; without bounds ‖g‖
  /// Step length as a multiple of the search direction; for projected-gradient, as a multiple of the gradient
  /// in the problem's own units. It is 0 at the first guess.
  double step_length = 0;
  /// Decrease of J that the method's model predicted for the last step, −g·d/2 for a quadratic model. It
  /// estimates the distance of J from its minimum. Infinite without a model. Not stored in checkpoints.
  double predicted_decrease = std::numeric_limits<double>::infinity();

  template <class Archive>
  void serialize(Archive& archive) {
    archive("iteration/number", number);
    archive("iteration/objective", objective);
    archive("iteration/gradient_norm", gradient_norm);
    archive("iteration/step_length", step_length);
  }
};

} // namespace signorini::optimize
