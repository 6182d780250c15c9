// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace signorini::optimize {

/// Options of regularised gradient steps (projected_gradient.h).
struct GradientOptions {
  /// Least ratio of the actual to the predicted decrease of an accepted step. It is small, so that a sweep
  /// that decreased J is not wasted.
  double sufficient = 0.1;
  /// Largest factor by which a step changes ω. It is limited, since the ratio of one step that crosses a kink
  /// hardly predicts the ratio of the next step.
  double omega_factor = 10;
  /// Least factor of ω after a rejected step, which at least halves the next step.
  double after_rejection = 2;
};

/// Options of the weak-Wolfe search (descent.h), 0 < sufficient < curvature_condition < 1 (Lewis, Overton
/// 2013). The values are those of Nocedal, Wright (2006), section 3.1, for Newton and quasi-Newton
/// directions.
struct WolfeOptions {
  double sufficient = 1e-4; ///< least decrease of J, relative to the decrease of J's tangent
  /// Steepest final slope, relative to the initial one; small values cost sweeps.
  double curvature_condition = 0.9;
};

/// Options of L-BFGS directions (lbfgs.h).
struct LbfgsOptions {
  /// Number of stored pairs of steps and gradient differences, at the upper end of the 3 to 20 of Nocedal,
  /// Wright (2006), section 7.2. Products with pairs cost no noticeable time compared with a sweep. Pairs
  /// cost the memory of 40 controls.
  std::size_t pairs = 20;
  /// Least cosine between step and gradient difference of a stored pair, √ε; below it rounding decides the
  /// sign of the curvature.
  double least_cosine = 1e-8;
};

/// Options of Newton directions by truncated conjugate gradients in a trust region (newton_cg.h).
struct NewtonOptions {
  /// Largest number of Hessian products for one direction; each costs two sweeps. The limit matters if
  /// curvatures spread so widely that conjugate gradients do not reach the residual.
  int products = 200;
  /// Conjugate gradients stop at the relative residual min(`residual`, r^`order`), where r is ‖g‖ divided by
  /// the largest ‖g‖ so far. Convergence is then of order 1.25 (Dembo, Eisenstat, Steihaug 1982). The order
  /// is below the usual 0.5, since more accuracy is wasted where active sets change.
  double residual = 0.2, order = 0.25;
  /// Ratios of the actual to the predicted decrease below and above which the trust radius is changed, and
  /// the factor of the change (Nocedal, Wright 2006, algorithm 4.1). The radius is halved rather than divided
  /// by 4, since the line search has already shortened poor steps.
  double poor = 0.25, good = 0.75, radius_factor = 2;
  /// First radius of the trust region. In the search's units, the first conjugate gradient step of a search
  /// is Cauchy's step, of length 1. With a radius of 1, rounding would decide whether that step lies within
  /// the region.
  double radius = 2;
};

/// Options of the bundle method at kinks (bundle_method.h), and of the switch to it (descent.h).
struct BundleOptions {
  /// Number of consecutive short steps after which the bundle method takes over; a single one may be due to a
  /// kink that the line search passes. A step is short if it is shorter than short_step times the longest
  /// step so far. The value of short_step is Options::ball(largest_tolerance), the radius within which the
  /// bundle method gathers gradients, since line searches with steps within this radius are wasted.
  int short_steps = 3;
  double short_step = 1e-3;
  /// Largest tolerance from which the bundle method derives its steps and distances. If Options::tolerance is
  /// larger, the iterates are those for this one. Certificates are tested with Options::tolerance and are
  /// thus found no later.
  double largest_tolerance = 1e-6;
  /// Largest number of cuts. Where J has kinks in k directions, k + 1 cuts certify a minimum (Carathéodory);
  /// with fewer, the search drops cuts and finds them again. Quadratic programs with 40 cuts cost nothing
  /// compared with a sweep.
  std::size_t cuts = 40;
  /// Largest dimension of the subspace. Each cut adds up to three dimensions: its gradient, a Hessian product
  /// and its offset. Each dimension takes the memory of one control.
  std::size_t dimension = 3 * cuts;
  /// Fractions of the largest dimension (or of Options::vectors if this is smaller). A subspace whose
  /// dimension exceeds the fraction restrict_above is restricted before the next round, which needs room for
  /// new vectors. The restriction is to the smaller fraction `restricted`, so that it is rarely repeated: it
  /// reads and writes all vectors. Cuts that carry the minimum-norm subgradient may take the fraction
  /// `carried`.
  double restrict_above = 0.75, restricted = 0.5, carried = 0.625;
  /// Largest number of rounds in a step, and of certificates in a step that new gradients do not confirm. A
  /// round costs one or more pairs of sweeps. These limits end a search that makes no progress because of
  /// rounding in J, or because selections of J are thinner than the ball in which gradients are gathered.
  int rounds = 100, unconfirmed = 10;
  /// A convex combination of the last iterates' gradients is tried as a certificate if it is shorter than a
  /// limit. Each rejected certificate multiplies this limit by length_reduction.
  double length_reduction = 0.5;
  /// Largest number of Hessian products for one direction; each costs two sweeps. After that many, the
  /// direction is tried even if the model's curvature along it is inaccurate: the cut from a failed trial
  /// costs less than further products and is as useful.
  int products = 10;
  /// Least decrease of J in a serious step, relative to the model's prediction. It is larger than that of the
  /// Wolfe search, since a null step is no loss: its cut improves the model.
  double sufficient = 0.1;
  /// Factor of the next trial length along a direction. A shorter trial follows if the cut from the last
  /// trial lies above J at the current point, where it is thus invalid. The selection of J at the trial is
  /// then not convex, or another selection lies between the two points and is met by the shorter step.
  double length_factor = 0.25;
  int null_steps = 3; ///< largest number along one direction; the model with their cuts then has a better one
  /// Weight above which a cut is said to carry the model's minimum. It is √ε, since the weights of gradients
  /// that differ by √ε of their length are accurate to √ε.
  double carrying = 1e-8;
  /// Fractions of the tolerance. If the model's subgradient is shorter than the fraction model_part,
  /// gradients are gathered at decreasing distances from the current point. The least is the distance over
  /// which a gradient changes by the fraction gathered_part, unless least_distance is larger. The sum of both
  /// fractions is below 1, so that new gradients confirm the certificate.
  double model_part = 0.5, gathered_part = 0.25;
  /// First and least distance at which gradients are gathered, relative to the ball's radius, and the factor
  /// of the next distance. The first distance is large, since gathering drops farther cuts: at a small
  /// distance all new gradients may belong to selections that the model contains already, and the other
  /// selections would be lost. At the least distance, 1e-9 of the longest step if the tolerance is
  /// `largest_tolerance`, differences of J still exceed rounding.
  double first_distance = 0.3, distance_factor = 0.1, least_distance = 1e-6;
  /// Bound of the relative rounding error of offsets and directions. They are differences of controls that
  /// are about 1/r times as long, where r is the ball's radius, and have errors of ε/r (2e-12 for r = 1e-4).
  double rounding = 1e-9;
  /// Distance from the subspace, relative to the length of a vector, below which the vector belongs to the
  /// subspace. It covers rounding of an orthogonalisation, ε times the dimension, with a margin.
  double dependent = 1e-12;
};

/// Constants of the optimisation methods. Lengths are in the units of a search (SearchUnits), so that no
/// constant depends on the problem's units.
struct Options {
  int max_iterations = 1000;
  double tolerance = 1e-6; ///< limit of the stationarity measure, relative to its first value
  /// Whether the bundle method takes over if steps become short or a line search fails; otherwise the search
  /// ends.
  bool through_kinks = true;
  /// Largest number of vectors that a method may store for longer than one evaluation takes.
  std::size_t vectors = std::numeric_limits<std::size_t>::max();
  /// Rounding error of a difference of two values of J, relative to J. Each value has half an ε from rounding
  /// and some more from its sums.
  double rounding = 4 * std::numeric_limits<double>::epsilon();
  GradientOptions gradient{};
  WolfeOptions wolfe{};
  LbfgsOptions lbfgs{};
  NewtonOptions newton{};
  BundleOptions bundle{};

  /// Returns the radius r of the ball in which a certificate to a tolerance gathers gradients, relative to
  /// the longest step. Selections of J closer than r count as meeting. If J is convex, a certificate of
  /// length ℓ proves J − J* ≤ r²/2 + ℓ times the distance from the minimiser, in the units of a search, in
  /// which the curvature is 1. With r as the root of the tolerance the two terms are of equal size.
  [[nodiscard]] static double ball(double tolerance) { return std::sqrt(tolerance); }

  /// Returns the largest decrease of J that rounding makes indistinguishable from none.
  [[nodiscard]] double negligible(double objective) const { return rounding * std::abs(objective); }
};

} // namespace signorini::optimize
