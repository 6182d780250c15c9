// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/archive.h"
#include "optimize/problem.h"
#include <algorithm>

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

} // namespace signorini::optimize
