// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/convergence.h"
#include "accuracy/quantities.h"

namespace signorini::accuracy {

/// How far the finest rung may be off, relative; see error_bar().
struct ReferenceBar {
  double value = 0;
  std::optional<double> size, step; ///< its parts, from rungs that differ in these alone; absent without any
  bool adjoint = false;             ///< whether the adjoint's estimate, which is of both, is in the value
  bool asymptotic = true;           ///< whether the parts are of orders that make sense
};

/// Errors of one quantity, rung by rung.
struct Errors {
  Quantity quantity;
  bool exact = false;
  std::optional<std::size_t> reference;        ///< the finest rung that has run, without an exact value; of
                                               ///< steps of one length and chosen ones the more certain
  std::optional<ReferenceBar> bar;             ///< of the reference; absent if nothing is known of it
  std::vector<std::optional<double>> error;    ///< relative
  std::vector<std::optional<double>> estimate; ///< of the error, from the run and coarser ones alone
  /// Estimate over error; absent unless the reference's own error, by its estimate, is small beside the
  /// error.
  std::vector<std::optional<double>> effectivity;
  /// The largest error of the rung and of all of its family (degree, scheme, steps of one length or chosen)
  /// that are as fine or finer in size and
  /// in step; absent if one of them has no number. Never less on a coarser rung, so that errors which are
  /// small by luck do not count.
  std::vector<std::optional<double>> envelope;
  std::vector<bool> pareto; ///< no cheaper rung has as small an envelope
};

/// Observed orders of one degree and scheme with steps that come about alike.
struct Orders {
  std::string quantity;
  int degree = 1;
  scene::ContactScheme scheme;
  bool chosen; ///< steps, by tolerances
  bool graded; ///< meshes, by sizes that vary
  std::optional<Order> space, time, both;
};

/// Errors, estimates, envelopes and Pareto front of one quantity. The reference's error bar is the sum of
/// those along the rungs of its step and along those of its size; of J also at least twice what the adjoint
/// estimates, and the sum of the moduli of its parts.
Errors errors(const Quantity& quantity, const std::vector<Result>& results, const Exact& exact);

/// What an estimate of J's error says of it at most: twice itself, as it was of 59 runs of 61
/// (tests/verification/effectivity.py), and the sum of the moduli of its parts, which make up for each other
/// by chance.
double most(const adjoint::ErrorParts& estimate);

/// The distance of a run's quantity to another's, relative; absent where one is not finite.
std::optional<double> distance(const Quantity& quantity, const Measured& run, const Measured& known);

/// Observed orders: in space at the shortest step and in time at the smallest size from the differences of
/// neighbouring rungs, in both along rungs that refine both, there from the errors if the exact value is
/// known. Needs three rungs, two with an exact value.
std::vector<Orders> orders(const Quantity& quantity, const std::vector<Result>& results, const Exact& exact);

/// For 10, 1 and 0.1 per cent the cheapest rung whose envelope and the reference's error bar together are no
/// more, or that there is none, in words.
std::vector<std::string> sentences(const Errors& errors, const std::vector<Result>& results,
                                   const scene::Scene& scene);

/// The highest order with which errors of a quantity fall with the size of elements of this degree r: r + 1
/// of a field, 2 r of a number, as of functionals by duality; and with the step: 2, of trapezoidal rules.
double highest_order_in_size(const Quantity& quantity, int degree);
constexpr double highest_order_in_step = 2;

/// What is left of differences by rounding, and for long runs somewhat more, relative.
constexpr double rounding = 1e-9;

/// "0.4 %"
std::string percent(double value, int digits = 2);

/// "an error bar of 0.4 %", of what, and that its orders make no sense if so.
std::string words(const ReferenceBar& bar);

} // namespace signorini::accuracy
