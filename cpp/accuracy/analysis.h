// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/convergence.h"
#include "accuracy/quantities.h"

namespace signorini::accuracy {

/// Error bar of a quantity on the reference rung, relative to the quantity's norm (error_bar()).
struct ReferenceBar {
  double value = 0;
  std::optional<double> size, step; ///< parts due to element size and to step length; absent if not estimated
  bool adjoint = false;             ///< whether `value` takes the adjoint's error estimate into account
  bool asymptotic = true;           ///< whether the parts are in the asymptotic range
};

/// Errors of one quantity on all rungs; the vectors have an entry for each rung. Errors are divided by the
/// norm of the exact value or, if that is unknown, of the reference; they are not divided if the quantity is
/// relative already (Quantity::already_relative).
struct Errors {
  Quantity quantity;
  bool exact = false; ///< whether errors are differences from the exact value
  /// Index of the reference, the finest rung that has run; absent if the exact value is known. If rungs with
  /// different kinds of steps or of mesh are equally fine in size, it is the one with the smallest error bar.
  std::optional<std::size_t> reference;
  std::optional<ReferenceBar> bar;             ///< error bar of the reference; absent if not estimated
  std::vector<std::optional<double>> error;    ///< error of each rung
  std::vector<std::optional<double>> estimate; ///< error estimated from the rung and coarser ones only
  /// Ratio of `estimate` to `error`; absent unless the estimated error of the reference is small relative to
  /// the rung's error.
  std::vector<std::optional<double>> effectivity;
  /// Largest error among the rung and those rungs of its family (same degree, scheme, kind of steps and kind
  /// of mesh) that are at least as fine in size and in step, without the reference. Absent if one of these
  /// errors is. Never decreases towards coarser rungs, so that an error that is small by coincidence does not
  /// count.
  std::vector<std::optional<double>> envelope;
  std::vector<bool> pareto; ///< whether all cheaper rungs have larger envelopes; false without an envelope
};

/// Observed orders of convergence of a quantity, for one degree, scheme, kind of steps and kind of mesh.
struct Orders {
  std::string quantity;
  int degree = 1;
  scene::ContactScheme scheme;
  bool varying_steps;                     ///< whether steps vary in length, controlled by tolerances
  bool graded;                            ///< whether element sizes vary within a mesh
  std::optional<Order> space, time, both; ///< orders in size, in step, and in both; absent if not observed
};

/// Computes errors, estimates, envelopes and Pareto front of one quantity. The error bar of the reference is
/// the sum of a part due to element size, from the rungs with the same step as the reference, and a part due
/// to step length, from the rungs with the same size. For J the bar is at least cautious_bound() of the
/// adjoint's error estimate.
Errors errors(const Quantity& quantity, const std::vector<RungResult>& results, const Exact& exact);

/// Cautious bound on the error of J from an estimate: the larger of two numbers. The first is twice the
/// modulus of the estimate, which exceeded the error in 59 of 61 runs (tests/verification/effectivity.py).
/// The second is the sum of the moduli of the estimate's parts, which cancel only by coincidence.
double cautious_bound(const adjoint::ErrorParts& estimate);

/// Distance between a quantity in `run` and in `known`, relative to the norm of the latter; absent if it is
/// not finite.
std::optional<double> distance(const Quantity& quantity, const Measured& run, const Measured& known);

/// Computes observed orders from the differences between neighbouring rungs: in space at the shortest step,
/// in time at the smallest size, and along rungs that refine both. An order from differences needs three
/// rungs. If the exact value is known, the order along rungs that refine both is computed from the errors
/// instead, and needs only two rungs.
std::vector<Orders> orders(const Quantity& quantity, const std::vector<RungResult>& results,
                           const Exact& exact);

/// Returns one sentence for each of the errors 10, 5, 1 and 0.1 per cent: it names the cheapest rung with at
/// most this error, or states that no rung is accurate enough. The error of a rung is the sum of its envelope
/// and of the reference's error bar.
std::vector<std::string> sentences(const Errors& errors, const std::vector<RungResult>& results,
                                   const scene::Scene& scene);

/// Highest possible order of convergence of a quantity in the element size: for elements of degree r it is
/// r + 1 for a field and 2 r for a number (a functional of the solution, by the duality argument).
double highest_order_in_size(const Quantity& quantity, int degree);
constexpr double highest_order_in_step = 2; ///< highest possible order in the step: the trapezoidal rule's

/// Rounding error in the difference of a quantity between two runs, relative to the quantity, with a margin
/// for long runs.
constexpr double rounding = 1e-9;

/// A ratio as text, such as "0.4 %".
std::string percent(double value, int digits = 2);

/// Describes an error bar, as "error bar 0.4 %", with notes on parts that are missing or not asymptotic.
std::string words(const ReferenceBar& bar);

} // namespace signorini::accuracy
