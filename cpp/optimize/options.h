// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace signorini::optimize {

/// Regularised gradient steps (projected_gradient.h).
struct GradientOptions {
  /// Least ratio of the actual to the predicted decrease. Small: a sweep that led down is not discarded.
  double sufficient = 0.1;
  /// Largest factor by which a step changes ω: one ratio, measured at a kink, hardly predicts the next.
  double change = 10;
  double after_rejection = 2; ///< least factor of ω after a rejected step: at least halves the next
};

/// Weak-Wolfe search (descent.h), with 0 < sufficient < flatter < 1 (Lewis, Overton 2013). The values
/// are those that Nocedal, Wright (2006), section 3.1, give for Newton's and quasi-Newton directions.
struct WolfeOptions {
  double sufficient = 1e-4; ///< least decrease relative to the tangent's: a step need only lead downhill
  double flatter = 0.9;     ///< largest final slope relative to the first: a flatter one costs sweeps
};

/// L-BFGS directions (lbfgs.h).
struct LbfgsOptions {
  /// Number of pairs of steps and gradient differences, at the upper end of the 3 to 20 of Nocedal, Wright
  /// (2006), section 7.2: products with pairs cost nothing beside a sweep, only 40 controls of memory.
  std::size_t pairs = 20;
  /// Least cosine between step and gradient difference, √ε: below it rounding decides the curvature's sign.
  double least_cosine = 1e-8;
};

/// Newton's directions by truncated conjugate gradients in a trust region (newton_cg.h).
struct NewtonOptions {
  /// Largest number of products for one direction, each two sweeps. The limit matters where curvatures spread
  /// so widely that conjugate gradients do not meet the residual.
  int products = 200;
  /// Largest relative residual, and its order in ‖g‖, for convergence of order 1.25 (Dembo,
  /// Eisenstat, Steihaug 1982). Looser than the usual 0.5 order: more accuracy is wasted where active sets
  /// change.
  double residual = 0.2, order = 0.25;
  /// Ratios of the actual to the predicted decrease below and above which the radius is adapted, and the
  /// factor (Nocedal, Wright 2006, algorithm 4.1; a search has shortened poor steps already, hence not 1/4).
  double poor = 0.25, good = 0.75, change = 2;
  /// First radius of the trust region. The first conjugate gradient step of a search is Cauchy's, of length 1
  /// in the search's units: with a radius of 1 rounding would decide whether it lies within.
  double radius = 2;
};

/// The bundle method at kinks (bundle_method.h) and when it takes over (descent.h).
struct BundleOptions {
  /// Number of consecutive short steps before the method takes over: one may be due to a single kink that the
  /// line search passes. Short: relative to the longest step, the ball of the finest tolerance below, so that
  /// the method starts before steps are lost within it.
  int short_steps = 3;
  double short_step = 1e-3;
  /// Tolerance of the method where a larger one is asked for: the iterates are then the same, and a
  /// certificate is met no later.
  double finest = 1e-6;
  /// Largest number of cuts. k + 1 certify a minimum where J has kinks in k directions (Carathéodory); with
  /// fewer, the search drops cuts and finds them again. Quadratic programs with 40 cost nothing beside a
  /// sweep.
  std::size_t cuts = 40;
  /// Largest dimension of the subspace, each a control in memory: for each cut a gradient, a Hessian product
  /// and an offset.
  std::size_t dimension = 3 * cuts;
  /// Parts of that dimension, or of Options::vectors if these are fewer. The subspace is restricted above the
  /// first, since a round adds vectors, and to the second, since a restriction reads and writes all of them.
  /// Cuts that carry the minimum-norm subgradient may take the third.
  double restrict_above = 0.75, restricted = 0.5, carried = 0.625;
  /// Largest numbers of rounds of a step, each one or more pairs of sweeps, and of unconfirmed certificates
  /// in it. They end a search without progress, due to rounding of J or selections thinner than the ball.
  int rounds = 100, unconfirmed = 10;
  /// Factor of the length required of a combination of the last iterates' gradients, after each rejected
  /// certificate.
  double again = 0.5;
  /// Largest number of Hessian products for one direction, each two sweeps. Where the model's curvature is
  /// still wrong, the direction is tried as it is: another cut costs less and gives as much.
  int products = 10;
  /// Least decrease of a serious step, relative to the model's. Larger than the Wolfe search's: a null step
  /// is no loss, since its cut improves the model.
  double sufficient = 0.1;
  /// Factor of the next length along a direction. A cut above J at the current point, from a selection that
  /// is not convex or lies beyond another, is invalid there: a shorter step meets the selection in between.
  double shorter = 0.25;
  int null_steps = 3; ///< largest number along one direction; the model then has a better one
  /// Weight above which a cut carries the model's minimum: √ε, the accuracy of the weights of gradients that
  /// differ by that part of their length.
  double carrying = 1e-8;
  /// Parts of the tolerance. If the model's subgradient is shorter than the first, gradients are gathered at
  /// decreasing distances, down to that over which they change by the second. Together they are 3/4, so that
  /// the certificate is confirmed.
  double model_part = 0.5, gathered_part = 0.25;
  /// First and least of these distances, relative to the ball, and the factor of the next. Nearer ones first
  /// would meet only the known selections and lose the cuts of the others. At the least, 1e-9 of the longest
  /// step, differences of J still exceed rounding.
  double farthest = 0.3, nearer = 0.1, least_distance = 1e-6;
  /// Relative rounding of offsets and directions: they are differences of controls 1/ball times as long, with
  /// an error of ε/ball = 2e-12 where the ball is 1e-4.
  double rounding = 1e-9;
  /// Distance of a vector from the subspace, relative to its length, below which it belongs to it: rounding
  /// of an orthogonalisation, ε times the dimension and some room.
  double dependent = 1e-12;
};

/// Constants of the methods. Lengths are relative to the units of a search (minimize.h), so that no constant
/// depends on the problem's units.
struct Options {
  int max_iterations = 1000;
  double tolerance = 1e-6; ///< bound of the stationarity measure, relative to the first
  /// Whether the bundle method takes over where steps become short or a search fails; else the search ends.
  bool through_kinks = true;
  /// Largest number of vectors that a method may store for longer than an evaluation takes.
  std::size_t vectors = std::numeric_limits<std::size_t>::max();
  /// Relative rounding error of J: the difference of two values, each with half an ε from its own rounding
  /// and some more from its sums.
  double rounding = 4 * std::numeric_limits<double>::epsilon();
  GradientOptions gradient{};
  WolfeOptions wolfe{};
  LbfgsOptions lbfgs{};
  NewtonOptions newton{};
  BundleOptions bundle{};

  /// Radius r of the ball in which a certificate to a tolerance gathers gradients, relative to the longest
  /// step. Selections of J closer than r count as met. If J is convex, a certificate of length ℓ proves J −
  /// J* ≤ r²/2 + ℓ times the distance from the minimiser, in a search's units and with its unit curvature.
  /// With r the root of the tolerance both terms are alike.
  [[nodiscard]] static double ball(double tolerance) { return std::sqrt(tolerance); }

  /// Largest decrease of J that is indistinguishable from none.
  [[nodiscard]] double negligible(double objective) const { return rounding * std::abs(objective); }
};

} // namespace signorini::optimize
