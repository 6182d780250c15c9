// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/options.h"
#include "optimize/span.h"
#include "optimize/unknowns.h"
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace signorini::optimize {

/// Symmetric positive definite approximation B of the Hessian from directions d (columns of D) and their
/// Hessian products y (columns of Y). B D = Y; on the complement of D, B is the least curvature σ of these
/// pairs:
///     B = σ (I − D (DᵀD)⁻¹ Dᵀ) + Y (DᵀY)⁻¹ Yᵀ
class Curvature {
public:
  /// Adds the pair of a direction d and its Hessian product y, with d·y > 0.
  void learn(const Coordinates& d, const Coordinates& y);

  /// Returns the largest ‖y‖/‖d‖ of all pairs added, an upper bound of their curvatures; 1 if there are none.
  [[nodiscard]] double largest() const { return largest_ > 0 ? largest_ : 1; }
  [[nodiscard]] bool empty() const { return known_.empty(); }
  void forget_oldest() { known_.erase(known_.begin()); }

  /// Returns the pairs (d, H d), the oldest first.
  [[nodiscard]] const std::vector<std::pair<Coordinates, Coordinates>>& directions_with_products() const {
    return known_;
  }
  /// Replaces the pairs; the least and the largest curvature do not change.
  void set_pairs(std::vector<std::pair<Coordinates, Coordinates>> pairs) { known_ = std::move(pairs); }

  /// Returns B (n × n); nothing if DᵀD or DᵀY is not positive definite.
  [[nodiscard]] std::optional<std::vector<double>> matrix(std::size_t n) const;

  template <class Archive>
  void serialize(Archive& archive, const std::string& name) {
    archive(name + "/least", least_);
    archive(name + "/largest", largest_);
    serialize_list(archive, name, known_, [&](auto& pair, const std::string& number) {
      archive(number + "/d", pair.first);
      archive(number + "/y", pair.second);
    });
  }

private:
  std::vector<std::pair<Coordinates, Coordinates>> known_;
  double least_ = 1; ///< least curvature σ
  double largest_ = 0;
};

/// Linear lower model d ↦ g·d − e of J about the current point, from a gradient g of J gathered nearby; d is
/// the offset from the current point.
struct Cut {
  Coordinates gathered;           ///< gradient at the point of evaluation
  Coordinates here;               ///< g: that gradient, moved to the current point by Hessian products
  Coordinates offset;             ///< point of evaluation minus current point
  double linearisation_error = 0; ///< e ≥ 0: distance of the cut below J at the current point
};

/// Convex combination of the gradients of cuts, with its length.
struct Combination {
  double length = 0;
  std::vector<double> weights; ///< weight of each cut; their sum is 1
};

/// Returns the minimum-norm subgradient: the shortest convex combination of the gradients gathered within the
/// ball of radius `radius` around the current point (Goldstein 1977). The first cut, with the gradient at the
/// current point, is always included. Throws SolverFailure if there is none, for example because gradients
/// are not finite.
[[nodiscard]] Combination minimum_norm_subgradient(std::span<const Cut> cuts, double radius);

/// Returns the value of the highest cut at the offset d, max_i (g_i·d − e_i).
[[nodiscard]] double highest(std::span<const Cut> cuts, const Coordinates& d);

/// Direction d from the current point, and the decrease of J that a model predicts along it.
struct Direction {
  Coordinates d, Hd;       ///< d, and H d, which is empty before a Hessian product
  Combination subgradient; ///< the model's subgradient at d, without the curvature term
  double predicted = 0;    ///< predicted decrease of J
};

/// Returns the minimiser d of max_i (g_i·d − e_i) + ½ d·Bd, by the dual quadratic program over the simplex.
/// Returns nothing if B (n × n) is not positive definite or the quadratic program cannot be solved.
[[nodiscard]] std::optional<Direction> model_minimiser(std::span<const Cut> cuts, std::vector<double> B,
                                                       std::size_t n);

/// Returns an offset of length `length` along which cut i rises above all other cuts in `carrying`, a list of
/// indices. Returns nothing if there are no others, or if the differences between the gradient of cut i and
/// theirs are linearly dependent.
[[nodiscard]] std::optional<Coordinates> offset_above(std::span<const Cut> cuts, std::size_t i,
                                                      std::span<const std::size_t> carrying, double length);

/// Model of J in a bundle method (Lemaréchal 1978) with the curvature of J (docs/method.md section 6), in
/// coordinates about the current point:
///     J(u + d) ≈ J(u) + max_i (g_i·d − e_i) + ½ d·Hd
/// where cut i has the gradient g_i and the linearisation error e_i ≥ 0. A single Hessian H suffices, since
/// the selections of a piecewise quadratic J have the same curvature along the edge where they meet.
class BundleModel {
public:
  /// Creates a model without curvature. The first of `cuts` is the cut of the current point.
  BundleModel(const BundleOptions& options, std::vector<Cut> cuts)
      : options_(options), cuts_(std::move(cuts)) {}

  [[nodiscard]] const std::vector<Cut>& cuts() const { return cuts_; }
  [[nodiscard]] const Curvature& curvature() const { return curvature_; }

  /// Returns the minimiser of the model in a space of n dimensions, with the matrix B of curvature() as H.
  /// Drops the oldest pairs of the curvature until B is positive definite. Throws SolverFailure.
  [[nodiscard]] Direction minimise(std::size_t n);

  /// Adds the Hessian product `Hd` of a direction to the curvature and corrects the direction's predicted
  /// decrease. Returns whether the model's curvature was accurate along the direction.
  bool learn(Direction& direction, Coordinates Hd);

  /// Makes a null step: adds the cut of the gradient g of J at the offset s, where J is lower than at the
  /// current point by `decrease` (negative: higher). `Hs`: H s. Returns the height of the cut above J at the
  /// current point; its modulus becomes the linearisation error (Kiwiel 1985).
  double null_step(const Coordinates& g, const Coordinates& s, const Coordinates& Hs, double decrease);

  /// Makes a serious step: moves the current point by s, where J is lower by `decrease` and has the gradient
  /// g. `Hs`: H s.
  void serious_step(const Coordinates& g, const Coordinates& s, const Coordinates& Hs, double decrease);

  /// Drops cuts that carry the model's minimum with these weights and were gathered farther than `distance`
  /// from the current point, since cuts of distant gradients may be invalid here. For each dropped cut,
  /// returns an offset of length `distance` along which it rises above the other cuts that carry the minimum,
  /// if offset_above() finds one.
  std::vector<Coordinates> drop_distant(const std::vector<double>& weights, double distance);

  /// Restricts the model to a subspace of at most `dimension` dimensions. Up to `carried` of these belong to
  /// the cuts that carry the minimum-norm subgradient of radius `radius`. The remaining ones belong to the
  /// latest pairs of the curvature and to the cuts that are highest at the last minimiser. All else is
  /// dropped. Returns an orthonormal basis of the subspace; coordinates refer to that basis from now on.
  std::vector<Coordinates> restrict(std::size_t dimension, std::size_t carried, double radius);

  template <class Archive>
  void serialize(Archive& archive) {
    curvature_.serialize(archive, "bundle/curvature");
    serialize_list(archive, "bundle/cuts", cuts_, [&](Cut& cut, const std::string& name) {
      archive(name + "/gathered", cut.gathered);
      archive(name + "/here", cut.here);
      archive(name + "/offset", cut.offset);
      archive(name + "/linearisation_error", cut.linearisation_error);
    });
    archive("bundle/last_minimiser", last_minimiser_);
  }

private:
  /// Drops the cut that is lowest at the last minimiser if no further cut may be stored. The cut of the
  /// current point stays: without it the model would not interpolate J there.
  void make_room();
  /// Returns the value g·d − e of a cut at the last minimiser d.
  [[nodiscard]] double at_minimiser(const Cut& cut) const;

  BundleOptions options_;
  Curvature curvature_;
  std::vector<Cut> cuts_;      ///< never empty: the first is that of the current point
  Coordinates last_minimiser_; ///< offset of the model's last nonzero minimiser from the current point
};

} // namespace signorini::optimize
