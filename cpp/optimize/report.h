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
  double length = 0;                  ///< of the combination
  double radius = 0;                  ///< of the ball around the current point
  std::vector<Shared<Vector>> points; ///< where the gradients were gathered
  std::vector<double> weights;

  template <class Archive>
  void serialize(Archive& archive, const std::string& name) {
    archive(name + "/length", length);
    archive(name + "/radius", radius);
    serialize_list(archive, name + "/points", points,
                   [&](Shared<Vector>& u, const std::string& number) { archive(number, u); });
    archive(name + "/weights", weights);
  }
};

/// What certifies that a point is stationary, if it is short and near enough.
template <Differentiable P>
struct GatheredGradients {
  using Vector = typename P::Vector;

  Certificate<Vector> certificate{};
  Vector sum;           ///< the combination
  bool complete = true; ///< J could be evaluated at all points

  /// Whether it is a certificate at most so long, of gradients within a ball of that radius.
  [[nodiscard]] bool confirms(double length, double ball) const {
    return complete && certificate.length <= length && certificate.radius <= ball;
  }
};

/// Evaluates the gradients of a convex combination anew: that of the current point, of the first weight, and
/// those at `point(i)` of the further weights that are positive, which `each(i, g)` is shown. The length is
/// the stationarity measure of their combination, blocked values included; it does not depend on a model.
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

/// Whether J is stationary at the same combination of the points. Where they lie on one smooth piece, its
/// gradient there is the combination of theirs: there is no kink between them.
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

/// How a search ended.
template <class Vector>
struct Result {
  Stop stop;
  std::optional<Certificate<Vector>> certificate = std::nullopt; ///< at a kink
  double first_norm = 0; ///< the gradient norm of which Options::tolerance is a part
};

/// The record of one iteration.
struct Iteration {
  int number = 0;
  double objective = 0;
  double gradient_norm = 0; ///< ‖u − P(u − s g)‖/s with s of the search's Units; without bounds ‖g‖
  /// Multiple taken of the direction; projected-gradient: of the problem's gradient; 0 at the first guess.
  double step_length = 0;
  /// What the model of the method promised of J for the last step, of a quadratic one -g·d/2: about the
  /// distance from a minimiser. Infinite if it has none. Not stored.
  double promised = std::numeric_limits<double>::infinity();

  template <class Archive>
  void serialize(Archive& archive) {
    archive("iteration/number", number);
    archive("iteration/objective", objective);
    archive("iteration/gradient_norm", gradient_norm);
    archive("iteration/step_length", step_length);
  }
};

} // namespace signorini::optimize
