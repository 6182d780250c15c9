// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <optional>
#include <span>
#include <vector>

/// Orders of convergence and error bars from the values of successively finer runs.
namespace signorini::accuracy {

/// Value of a quantity for one width h, an element size or a step length.
struct Value {
  double width;
  std::span<const double> samples; ///< one number, or the scaled samples of a field
};

/// Values of a quantity, from coarse to fine.
using Chain = std::vector<Value>;

/// Prior knowledge of a quantity.
struct Limits {
  double order = 2;    ///< highest possible order of convergence
  double rounding = 0; ///< largest difference of values that rounding explains
};

/// An observed order of convergence: with x(h) = x + C h^p the differences d_i of successive values satisfy
///     |d_{i+1}| / |d_i| = (h_{i+1}^p − h_{i+2}^p) / (h_i^p − h_{i+1}^p),
/// which is ρ^−p if successive widths have the ratio ρ, so that three values give one p.
///
/// Values are in the *asymptotic range*, where this law applies, if successive differences have the same
/// direction and p is within bounds. The lower bound is 1/4: with a smaller p, halving the error would take a
/// width 16 times smaller. The upper bound is 1/2 above the highest possible order, since errors scatter on
/// unstructured meshes: a scatter of one fifth in two neighbours shifts p by log₂(1.2/0.8) = 0.58. Errors
/// that pass through zero, oscillate or do not decrease yet are outside of the range.
struct Order {
  /// Mean of p over all triples of successive values; over all pairs if p comes from errors.
  double slope = 0;
  double least = 0, largest = 0; ///< range of p over these triples or pairs
  /// Whether the finest values, at least three (two with an exact value), are in the asymptotic range. If so,
  /// the members above come from these values only, else from all values.
  bool asymptotic = false;
};

/// Observed order from differences of successive values. The finest values are left out as long as they
/// differ from their predecessor only by rounding. Absent if fewer than three values remain.
std::optional<Order> observed_order(const Chain& chain, const Limits& limits);

/// Observed order from distances to the exact value, |e_{i+1}| / |e_i| = (h_{i+1} / h_i)^p, so that two
/// values give one p. The finest values are left out as long as they differ from the exact value only by
/// rounding. Absent if fewer than two values remain.
std::optional<Order> observed_order(const Chain& chain, std::span<const double> exact, const Limits& limits);

/// Error bar of the finest value, in the norm of the samples; absent for fewer than two values.
///
/// If the three finest values are in the asymptotic range, the bar is twice Richardson's |d| / (ρ^p − 1),
/// where d is the difference of the two finest values, ρ the ratio of their widths, and p is limited to the
/// highest possible order. Else it is three times the largest difference between any two of the three finest
/// values, or between the only two. This is the grid convergence index with the factor 2 in place of 1.25
/// (P. J. Roache, *Verification of codes and calculations*, AIAA J. 36 (1998); L. Eça, M. Hoekstra, *A
/// procedure for the estimation of the numerical uncertainty of CFD calculations based on grid refinement
/// studies*, J. Comput. Phys. 262 (2014)). If values scatter by 5 %, and the next term of their expansion in
/// h is up to half as large as the leading one, the factor 1.25 covers the error in 83 of 100 cases, the
/// factor 2 in 98. The bar is an estimate, not a bound: convergence to a wrong value remains undetected.
std::optional<double> error_bar(const Chain& chain, const Limits& limits);

} // namespace signorini::accuracy
