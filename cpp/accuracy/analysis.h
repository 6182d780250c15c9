// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/convergence.h"
#include "accuracy/quantities.h"

namespace signorini::accuracy {

/// Error bar of the finest rung, relative; see error_bar().
struct ReferenceBar {
  double value = 0;
  std::optional<double> size, step; ///< its parts, from rungs that differ in these alone; absent without any
  bool adjoint = false;             ///< whether the value includes the adjoint's estimate of both
  bool asymptotic = true;           ///< whether the parts are in the asymptotic range
};

/// Errors of one quantity, rung by rung.
struct Errors {
  Quantity quantity;
  bool exact = false;
  std::optional<std::size_t> reference;        ///< the finest rung that has run, without an exact value; of
                                               ///< steps of one length and chosen ones the smaller error bar
  std::optional<ReferenceBar> bar;             ///< error bar of the reference; absent if it has none
  std::vector<std::optional<double>> error;    ///< relative
  std::vector<std::optional<double>> estimate; ///< estimated error, from the run and coarser ones alone
  /// Estimate over error; absent unless the reference's own error, by its estimate, is small beside the
  /// error.
  std::vector<std::optional<double>> effectivity;
  /// The largest error of the rung and of those in its family (degree, scheme, kind of steps and of mesh)
  /// that are as fine or finer in size and in step. Absent if one of them has no number. It never falls
  /// towards coarser rungs, so that errors that are small by coincidence do not count.
  std::vector<std::optional<double>> envelope;
  std::vector<bool> pareto; ///< no cheaper rung has as small an envelope
};

/// Observed orders of a quantity for one degree, scheme, kind of steps and kind of mesh.
struct Orders {
  std::string quantity;
  int degree = 1;
  scene::ContactScheme scheme;
  bool chosen; ///< whether the motion chooses the steps, by tolerances
  bool graded; ///< whether the sizes of the meshes vary
  std::optional<Order> space, time, both;
};

/// Errors, estimates, envelopes and Pareto front of one quantity. The reference's error bar adds two: one
/// from the rungs with its step, one from those with its size. For J it is no smaller than most() of the
/// adjoint's error estimate.
Errors errors(const Quantity& quantity, const std::vector<Result>& results, const Exact& exact);

/// Cautious bound of J's error from its estimate: twice the estimate, which covered 59 of 61 runs
/// (tests/verification/effectivity.py). It is at least the sum of the moduli of its parts, which cancel only
/// by coincidence.
double most(const adjoint::ErrorParts& estimate);

/// Relative distance of a run's quantity to another's; absent where one is not finite.
std::optional<double> distance(const Quantity& quantity, const Measured& run, const Measured& known);

/// Observed orders from the differences of neighbouring rungs: in space at the shortest step, in time at the
/// smallest size, and along rungs that refine both. The last are from the errors if the exact value is known.
/// Needs three rungs, two with an exact value.
std::vector<Orders> orders(const Quantity& quantity, const std::vector<Result>& results, const Exact& exact);

/// Returns sentences that name, for 10, 5, 1 and 0.1 per cent, the cheapest rung whose envelope and the
/// reference's error bar together are no more, or that there is none.
std::vector<std::string> sentences(const Errors& errors, const std::vector<Result>& results,
                                   const scene::Scene& scene);

/// Highest order in the element size with which errors of a quantity can fall. For degree r it is r + 1 for a
/// field, 2 r for a number, as for functionals by duality. In the step it is 2, as for trapezoidal rules.
double highest_order_in_size(const Quantity& quantity, int degree);
constexpr double highest_order_in_step = 2;

/// Rounding in the difference of two runs, relative, with a margin for long runs.
constexpr double rounding = 1e-9;

/// A ratio as text, such as "0.4 %".
std::string percent(double value, int digits = 2);

/// The bar in words, such as "error bar 0.4 %", with notes if a part is not verified or not asymptotic.
std::string words(const ReferenceBar& bar);

} // namespace signorini::accuracy
