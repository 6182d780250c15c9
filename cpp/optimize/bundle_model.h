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

/// A symmetric positive definite approximation B of the Hessian from pairs of directions and their Hessian
/// products, B D = Y, with the least curvature σ among these on the complement:
///     B = σ (I − D (DᵀD)⁻¹ Dᵀ) + Y (DᵀY)⁻¹ Yᵀ
class Curvature {
public:
  /// Adds the pair H d = y, d·y > 0.
  void learn(const Coordinates& d, const Coordinates& y);

  /// The largest ‖y‖/‖d‖ of the pairs, at least their largest curvature; 1 without any.
  [[nodiscard]] double largest() const { return largest_ > 0 ? largest_ : 1; }
  [[nodiscard]] bool empty() const { return known_.empty(); }
  void forget_oldest() { known_.erase(known_.begin()); }

  /// Pairs (d, H d), the oldest first.
  [[nodiscard]] const std::vector<std::pair<Coordinates, Coordinates>>& pairs() const { return known_; }
  /// Replaces the pairs; keeps the least and the largest curvature.
  void set_pairs(std::vector<std::pair<Coordinates, Coordinates>> pairs) { known_ = std::move(pairs); }

  /// B (n × n); none if DᵀD or DᵀY is not positive definite.
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
  double least_ = 1; ///< σ
  double largest_ = 0;
};

/// Linear function d ↦ g·d − e of the offset d from the current point, by a gradient of J gathered nearby.
struct Cut {
  Coordinates gathered;           ///< the gradient where it was evaluated
  Coordinates here;               ///< g: the gradient moved to the current point by Hessian products
  Coordinates offset;             ///< point of evaluation minus current point
  double linearisation_error = 0; ///< e ≥ 0: distance of the cut below J at the current point
};

/// A convex combination of gradients of cuts.
struct Combination {
  double length = 0;
  std::vector<double> weights; ///< weight of each cut, Σ = 1
};

/// Returns the minimum-norm subgradient: the shortest convex combination of the gradients gathered within the
/// ball of this radius around the current point (Goldstein 1977). The gradient at the current point, that of
/// the first cut, is always among them. Throws SolverFailure if there is none, as for gradients that are not
/// finite.
[[nodiscard]] Combination minimum_norm_subgradient(std::span<const Cut> cuts, double radius);

/// max_i (g_i·d − e_i).
[[nodiscard]] double highest(std::span<const Cut> cuts, const Coordinates& d);

/// Direction from the current point, with the prediction of a model of J.
struct Direction {
  Coordinates d, Hd;       ///< H d is empty before a Hessian product
  Combination subgradient; ///< subgradient of the model at d, without the curvature term
  double predicted = 0;    ///< predicted decrease of J
};

/// Returns the minimiser d of max_i (g_i·d − e_i) + ½ d·Bd, by the dual quadratic program over the simplex;
/// none if B (n × n) is not positive definite or the quadratic program is not solved.
[[nodiscard]] std::optional<Direction> model_minimiser(std::span<const Cut> cuts, std::vector<double> B,
                                                       std::size_t n);

/// Returns an offset of this length along which cut i rises above the others of `carrying`; none if there are
/// no others or their edges with i are dependent.
[[nodiscard]] std::optional<Coordinates> offset_above(std::span<const Cut> cuts, std::size_t i,
                                                      std::span<const std::size_t> carrying, double length);

/// The model of a bundle method (Lemaréchal 1978) with the curvature of J (docs/method.md section 6), in
/// coordinates about the current point:
///     J(u + d) ≈ J(u) + max_i (g_i·d − e_i) + ½ d·Hd
/// with cuts of gradients g_i and linearisation errors e_i ≥ 0. A single Hessian H suffices: the selections
/// of a piecewise quadratic J have the same curvature along the edge where they meet.
class BundleModel {
public:
  /// Makes a model without curvature. The first of the cuts is that of the current point.
  BundleModel(const BundleOptions& options, std::vector<Cut> cuts)
      : options_(options), cuts_(std::move(cuts)) {}

  [[nodiscard]] const std::vector<Cut>& cuts() const { return cuts_; }
  [[nodiscard]] const Curvature& curvature() const { return curvature_; }

  /// Returns the minimiser in a space of n dimensions. Drops the oldest pairs of the curvature until H is
  /// positive definite. Throws SolverFailure.
  [[nodiscard]] Direction minimise(std::size_t n);

  /// Adds the Hessian product H d of a direction and corrects its predicted decrease. Returns whether the
  /// curvature of the model was accurate along it.
  bool learn(Direction& direction, Coordinates Hd);

  /// Null step: adds the cut of the gradient g of J at s, where J is lower by `decrease`. Returns the height
  /// of the cut above J at the current point; the linearisation error is its modulus (Kiwiel 1985).
  double null_step(const Coordinates& g, const Coordinates& s, const Coordinates& Hs, double decrease);

  /// Serious step: moves the current point by s, where J is lower by `decrease` and has the gradient g.
  void serious_step(const Coordinates& g, const Coordinates& s, const Coordinates& Hs, double decrease);

  /// Drops cuts that carry the model's minimum with these weights and were gathered farther than `distance`
  /// from the current point, since cuts of distant gradients may be invalid here. Returns an offset of that
  /// length for each of them, where it is the highest.
  std::vector<Coordinates> drop_distant(const std::vector<double>& weights, double distance);

  /// Restricts the model to a subspace. The cuts that carry the minimum-norm subgradient of this radius take
  /// up to `carried` dimensions. Then, up to `dimension` in all, follow the latest pairs of the curvature and
  /// the cuts that are highest at the last minimiser; the rest is dropped. Returns an orthonormal basis of
  /// the subspace, to which coordinates refer from now on.
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
  /// Drops the cut that is lowest at the last minimiser, if there are as many as may be stored. The cut of
  /// the current point stays: without it the model would not interpolate J there.
  void make_room();
  /// g·d − e at the last minimiser d.
  [[nodiscard]] double at_minimiser(const Cut& cut) const;

  BundleOptions options_;
  Curvature curvature_;
  std::vector<Cut> cuts_;      ///< never empty: the first is that of the current point
  Coordinates last_minimiser_; ///< offset from the current point
};

} // namespace signorini::optimize
