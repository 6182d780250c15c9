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
  /// Largest factor by which a step changes ω, since a ratio measured at a kink hardly predicts the next one.
  double change = 10;
  /// Least factor of ω after a rejected step, which at least halves the next step.
  double after_rejection = 2;
};

/// Options of the weak-Wolfe search (descent.h), 0 < sufficient < flatter < 1 (Lewis, Overton 2013). The
/// values are those of Nocedal, Wright (2006), section 3.1, for Newton and quasi-Newton directions.
struct WolfeOptions {
  double sufficient = 1e-4; ///< least decrease relative to that of J's tangent
  double flatter = 0.9;     ///< largest final slope relative to the initial one; a smaller value costs sweeps
};

/// Options of L-BFGS directions (lbfgs.h).
struct LbfgsOptions {
  /// Number of stored pairs of steps and gradient differences, at the upper end of the 3 to 20 of Nocedal,
  /// Wright (2006), section 7.2. Products with pairs cost nothing compared with a sweep, only the memory of
  /// 40 controls.
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
  /// Largest residual relative to the gradient, and its order in ‖g‖, for convergence of order 1.25 (Dembo,
  /// Eisenstat, Steihaug 1982). The values are looser than the usual 0.5 order, since more accuracy is wasted
  /// where active sets change.
  double residual = 0.2, order = 0.25;
  /// Ratios of the actual to the predicted decrease below and above which the trust radius is changed, and
  /// the factor of the change (Nocedal, Wright 2006, algorithm 4.1). The radius is halved rather than divided
  /// by 4, since the line search has already shortened poor steps.
  double poor = 0.25, good = 0.75, change = 2;
  /// First radius of the trust region. In the search's units, the first conjugate gradient step of a search
  /// is Cauchy's step, of length 1. With a radius of 1, rounding would decide whether that step lies within
  /// the region.
  double radius = 2;
};

/// Options of the bundle method at kinks (bundle_method.h), and of the switch to it (descent.h).
struct BundleOptions {
  /// Number of consecutive short steps after which the bundle method takes over; a single one may be due to a
  /// kink that the line search passes. A step is short if its length relative to the longest step is below
  /// short_step. short_step is the radius, relative to the longest step, within which a
  /// certificate of the finest tolerance gathers gradients: the method starts before steps are wasted there.
  int short_steps = 3;
  double short_step = 1e-3;
  /// Largest tolerance with which the bundle method works, even if a larger one is asked for. The iterates
  /// are then the same, and a certificate is found no later.
  double finest = 1e-6;
  /// Largest number of cuts. Where J has kinks in k directions, k + 1 cuts certify a minimum (Carathéodory);
  /// with fewer, the search drops cuts and finds them again. Quadratic programs with 40 cuts cost nothing
  /// compared with a sweep.
  std::size_t cuts = 40;
  /// Largest dimension of the subspace, each dimension a control in memory: a gradient, a Hessian product and
  /// an offset for each cut.
  std::size_t dimension = 3 * cuts;
  /// Fractions of the largest dimension (or of Options::vectors if this is smaller). The subspace is
  /// restricted if its dimension exceeds the first fraction, since a round adds vectors. It is restricted to
  /// the second, since a restriction reads and writes all vectors. Cuts that carry the minimum-norm
  /// subgradient may take up to the third.
  double restrict_above = 0.75, restricted = 0.5, carried = 0.625;
  /// Largest numbers of rounds in a step (each one or more pairs of sweeps) and of unconfirmed certificates
  /// in a step. They end a search without progress, due to rounding of J or to selections thinner than the
  /// ball.
  int rounds = 100, unconfirmed = 10;
  /// Factor by which the required length of a combination of the last iterates' gradients shrinks after each
  /// rejected certificate.
  double again = 0.5;
  /// Largest number of Hessian products for one direction; each costs two sweeps. If the model's curvature is
  /// still wrong then, the direction is tried as it is: another cut costs less and is as useful.
  int products = 10;
  /// Least decrease of J in a serious step, relative to the model's prediction. It is larger than that of the
  /// Wolfe search, since a null step is no loss: its cut improves the model.
  double sufficient = 0.1;
  /// Factor of the next trial length along a direction. A cut above J at the current point, from a selection
  /// that is not convex or lies beyond another one, is invalid there; a shorter step meets the selection in
  /// between.
  double shorter = 0.25;
  int null_steps = 3; ///< largest number along one direction, after which the model has a better direction
  /// Weight above which a cut is said to carry the model's minimum: √ε, the accuracy of the weights of
  /// gradients that differ by that fraction of their length.
  double carrying = 1e-8;
  /// Fractions of the tolerance. If the model's subgradient is shorter than the first fraction, gradients are
  /// gathered at decreasing distances, down to that over which gradients change by the second. Together the
  /// fractions are 3/4, so that the certificate is confirmed.
  double model_part = 0.5, gathered_part = 0.25;
  /// First and least distance at which gradients are gathered, relative to the ball's radius, and the factor
  /// of the next distance. Small distances first would meet only selections that the model contains and lose
  /// the cuts of the others. At the least distance, 1e-9 of the longest step, differences of J still exceed
  /// rounding.
  double farthest = 0.3, nearer = 0.1, least_distance = 1e-6;
  /// Relative rounding of offsets and directions. They are differences of controls that are 1/ball times as
  /// long, with an error of ε/ball = 2e-12 for a ball of radius 1e-4.
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
