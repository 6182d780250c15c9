// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <optional>
#include <span>
#include <vector>

/// What the values of ever finer runs tell of the limit that they come to.
namespace signorini::accuracy {

/// A quantity at one width h, the size of elements or the length of steps: a number, or the samples of a
/// field.
struct Value {
  double width;
  std::span<const double> samples;
};

/// Values from coarse to fine.
using Chain = std::vector<Value>;

/// What is known of a quantity beforehand.
struct Limits {
  double order = 2;    ///< the highest with which its error can fall
  double rounding = 0; ///< differences of this size are
};

/// An observed order of convergence: with x(h) = x + C h^p the differences d_i of successive values satisfy
///     |d_{i+1}| / |d_i| = (h_{i+1}^p − h_{i+2}^p) / (h_i^p − h_{i+1}^p),
/// which is ρ^−p where each width is the ρth part of the one before, so that three values give one p.
///
/// They are in the *asymptotic range*, where that law holds and p means something, if successive differences
/// point the same way and fall, with p of a quarter at least (or half the error would take a width of a
/// sixteenth), and not faster than the method can, by half an order at most: a scatter of a fifth in the
/// errors of two neighbours, as unstructured meshes have, shifts log₂ of their ratio by log₂(1.2/0.8) = 0.58.
/// Errors that pass through zero, chatter or have not begun to fall do not pass.
struct Order {
  double slope = 0;              ///< mean of the p of neighbours
  double least = 0, largest = 0; ///< of these
  /// If true the values above are of the finest values that pass, three or more; else of all.
  bool asymptotic = false;
};

/// The order by differences of successive values; absent for fewer than three that differ by more than
/// rounding.
std::optional<Order> observed_order(const Chain& chain, const Limits& limits);

/// The order by distances to the exact value: |e_{i+1}| / |e_i| = (h_{i+1} / h_i)^p, so that two values give
/// one p; absent for fewer.
std::optional<Order> observed_order(const Chain& chain, std::span<const double> exact, const Limits& limits);

/// An error bar of the finest value, in the norm of the samples; absent for fewer than two values.
///
/// In the asymptotic range of the three finest, twice Richardson's |d| / (ρ^p − 1), p being at most the
/// method's; else three times the largest difference between any two of them, or between the two that there
/// are. That is the grid convergence index (P. J. Roache, *Verification of codes and calculations*, AIAA J.
/// 36 (1998); L. Eça, M. Hoekstra, *A procedure for the estimation of the numerical uncertainty of CFD
/// calculations based on grid refinement studies*, J. Comput. Phys. 262 (2014)) but for its factor of 1.25,
/// which holds in 83 of 100 cases, where 2 holds in 98, with a scatter of a twentieth and a next power of up
/// to half the size. It is an estimate, no bound: of a value that converges to something else it knows
/// nothing.
std::optional<double> error_bar(const Chain& chain, const Limits& limits);

} // namespace signorini::accuracy
