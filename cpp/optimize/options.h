// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace signorini::optimize {

/// Regularised gradient steps (projected_gradient.h).
struct GradientOptions {
  /// Least ratio of the actual to the predicted decrease. Small: a sweep that led down is not thrown away.
  double sufficient = 0.1;
  /// Largest factor by which a step changes ω: one ratio, measured at a kink, says little of the next step.
  double change = 10;
  double after_rejection = 2; ///< least factor of ω then: a rejected step is at least halved
};

/// Weak-Wolfe search (descent.h), with 0 < sufficient < flatter < 1 (Lewis, Overton 2013). The values
/// are those that Nocedal, Wright (2006), section 3.1, give for Newton's and quasi-Newton directions.
struct WolfeOptions {
  double sufficient = 1e-4; ///< least decrease, of the tangent's: a step need not be good, only downhill
  double flatter = 0.9;     ///< largest slope at the end, of the first: a better one costs sweeps of its own
};

/// L-BFGS directions (lbfgs.h).
struct LbfgsOptions {
  /// Pairs of steps and gradient differences, at the upper end of the 3 to 20 of Nocedal, Wright (2006),
  /// section 7.2: products with pairs cost nothing beside a sweep, only 40 controls of memory.
  std::size_t pairs = 20;
  /// Least cosine between step and gradient difference, √ε: below it rounding decides the curvature's sign.
  double least_cosine = 1e-8;
};

/// Newton's directions by truncated conjugate gradients in a trust region (newton_cg.h).
struct NewtonOptions {
  /// Products for one direction, each two sweeps: bounds an iteration where curvatures spread so widely that
  /// conjugate gradients do not meet the residual.
  int products = 200;
  /// Largest relative residual, and its order in ‖g‖, 1.25 being that of the convergence (Dembo, Eisenstat,
  /// Steihaug 1982). Looser than the usual 0.5 order: more accuracy is wasted where active sets change.
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
  /// Steps in a row that are short, relative to the longest, before the method takes over: one may be due to
  /// a single kink that the line search passes. Short is the ball of the finest tolerance below: the method
  /// starts before steps are lost within it.
  int short_steps = 3;
  double short_step = 1e-3;
  /// The tolerance that the method works to where less is asked for: its way is then the same, and a
  /// certificate is met no later.
  double finest = 1e-6;
  /// Cuts. k + 1 certify a minimum where J has kinks in k directions (Carathéodory); with fewer the search
  /// goes on by leaving and finding cuts again. Quadratic programs with 40 cost nothing beside a sweep.
  std::size_t cuts = 40;
  /// Largest dimension of the subspace, each a control in memory: for each cut a gradient, a Hessian product
  /// and an offset.
  std::size_t dimension = 3 * cuts;
  /// Part of that, or of Options::vectors where these are fewer, above which the subspace is restricted, for
  /// a round adds vectors; the part to which it is, for a restriction reads and writes all of them; and
  /// the part that may be left to what carries the minimum-norm subgradient.
  double restrict_above = 0.75, restricted = 0.5, carried = 0.625;
  /// Rounds of a step, each one or more pairs of sweeps, and unconfirmed certificates in it: end a search
  /// that J's rounding, or pieces thinner than the ball, keep from making progress.
  int rounds = 100, unconfirmed = 10;
  /// So much shorter must a combination of the last iterates' gradients be after one that was no certificate.
  double again = 0.5;
  /// Hessian products for one direction, each two sweeps. Where the model's curvature is still wrong, the
  /// direction is tried as it is: another cut tells as much for less.
  int products = 10;
  /// Decrease that makes a step serious, of the model's. Above the Wolfe search's, for a null step is no
  /// loss: its cut improves the model.
  double sufficient = 0.1;
  /// Factor of the next length along a direction. A cut above J at the current point, from a piece that is
  /// not convex or lies beyond another, is of no use there: the piece in between is nearer.
  double shorter = 0.25;
  int null_steps = 3; ///< along one direction, at decreasing lengths; the model then knows a better one
  /// Weight of a cut above which it carries the model's minimum: √ε, as accurate as the weights
  /// of gradients are that differ by that part of their length.
  double carrying = 1e-8;
  /// Where the model's subgradient is shorter than the first, of the tolerance, gradients are gathered at
  /// ever smaller distances down to that over which they change by the second: together 3/4, so that the
  /// certificate is confirmed.
  double model_part = 0.5, gathered_part = 0.25;
  /// The first of these distances, of the ball, and the factor of the next. Nearer ones first would meet only
  /// the pieces that are known, and lose the cuts of the others. At the least, 1e-9 of the longest step,
  /// differences of J still exceed rounding.
  double farthest = 0.3, nearer = 0.1, least_distance = 1e-6;
  /// Relative rounding of offsets and directions: they are differences of controls 1/ball times as long, with
  /// an error of ε/ball = 2e-12 where the ball is 1e-4.
  double rounding = 1e-9;
  /// Part of a vector out of the subspace, relative to its length, below which it belongs to it: rounding of
  /// an orthogonalisation, ε times the dimension and some room.
  double dependent = 1e-12;
};

/// Every constant of the methods. Lengths are relative to the units of a search (minimize.h), so that none
/// depends on the problem's.
struct Options {
  int max_iterations = 1000;
  double tolerance = 1e-6; ///< of the stationarity measure, relative to the first
  /// Whether the bundle method takes over where steps become short or a search fails; else the search ends.
  bool through_kinks = true;
  /// Vectors that a method may store for longer than an evaluation takes.
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
  /// step: pieces of J closer than that count as met. Of a convex J a certificate of length ℓ proves J − J* ≤
  /// r²/2 + ℓ times the distance from the minimiser, in a search's units and with its unit curvature; where r
  /// is the root of the tolerance both parts are alike.
  [[nodiscard]] static double ball(double tolerance) { return std::sqrt(tolerance); }

  /// A decrease of J that is indistinguishable from none.
  [[nodiscard]] double negligible(double objective) const { return rounding * std::abs(objective); }
};

} // namespace signorini::optimize
