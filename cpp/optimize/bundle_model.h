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

  /// The pairs, the oldest first.
  [[nodiscard]] const std::vector<std::pair<Coordinates, Coordinates>>& pairs() const { return known_; }
  /// Replaces the pairs; what is known of least and largest curvature stays.
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

/// The linear function d ↦ g·d − e, d from the current point, of a gradient of J gathered near that point.
struct Cut {
  Coordinates gathered;           ///< the gradient where it was evaluated
  Coordinates here;               ///< g: the same moved to the current point by Hessian products
  Coordinates offset;             ///< from the current point to where it was evaluated
  double linearisation_error = 0; ///< e ≥ 0: how far the cut lies below J at the current point
};

/// A convex combination of gradients of cuts.
struct Combination {
  double length = 0;
  std::vector<double> weights; ///< of all cuts, Σ = 1
};

/// The minimum-norm subgradient: the shortest convex combination of the gradients gathered within the ball of
/// this radius around the current point, whose own gradient, that of the first cut, is always among them
/// (Goldstein 1977). Throws SolverFailure if there is none, of gradients that are not finite.
[[nodiscard]] Combination minimum_norm_subgradient(std::span<const Cut> cuts, double radius);

/// max_i (g_i·d − e_i).
[[nodiscard]] double highest(std::span<const Cut> cuts, const Coordinates& d);

/// A direction from the current point, with what a model of J foretells of it.
struct Direction {
  Coordinates d, Hd;       ///< H d is empty as long as no Hessian product was made
  Combination subgradient; ///< of the model at d; without its curvature
  double predicted = 0;    ///< decrease of J
};

/// The minimiser d of max_i (g_i·d − e_i) + ½ d·Bd, by its dual, a quadratic program over the simplex; none
/// if B (n × n) is not positive definite or the program has no solution.
[[nodiscard]] std::optional<Direction> model_minimiser(std::span<const Cut> cuts, std::vector<double> B,
                                                       std::size_t n);

/// An offset of this length along which cut i rises above the others of `carrying`; none if there are no
/// others or their edges with i are dependent.
[[nodiscard]] std::optional<Coordinates> offset_above(std::span<const Cut> cuts, std::size_t i,
                                                      std::span<const std::size_t> carrying, double length);

/// The model of a bundle method (Lemaréchal 1978) with the curvature of J (docs/method.md section 6), in
/// coordinates about the current point:
///     J(u + d) ≈ J(u) + max_i (g_i·d − e_i) + ½ d·Hd
/// with cuts of gradients g_i and linearisation errors e_i ≥ 0, and a single Hessian H, since the pieces of a
/// piecewise quadratic J have the same curvature along the edge where they meet.
class BundleModel {
public:
  /// A model without curvature. The first of the cuts is that of the current point.
  BundleModel(const BundleOptions& options, std::vector<Cut> cuts)
      : options_(options), cuts_(std::move(cuts)) {}

  [[nodiscard]] const std::vector<Cut>& cuts() const { return cuts_; }
  [[nodiscard]] const Curvature& curvature() const { return curvature_; }

  /// The minimiser in a space of n dimensions. Where the known curvature is inconsistent, so that it gives no
  /// positive definite H, the oldest pair is forgotten. Throws SolverFailure.
  [[nodiscard]] Direction minimise(std::size_t n);

  /// Learns the Hessian product H d of a direction and corrects what is predicted of it. Returns whether the
  /// model had known its curvature.
  bool learn(Direction& direction, Coordinates Hd);

  /// Adds the cut of the gradient g of J at s, where J is lower by `decrease`: a null step. Returns how far
  /// the cut lies above J at the current point. Its linearisation error is the modulus of that (Kiwiel 1985).
  double null_step(const Coordinates& g, const Coordinates& s, const Coordinates& Hs, double decrease);

  /// Moves the current point by s, where J is lower by `decrease` and has the gradient g.
  void serious_step(const Coordinates& g, const Coordinates& s, const Coordinates& Hs, double decrease);

  /// Drops the cuts with weights that carry the model's minimum which were gathered farther than `distance`
  /// from the current point, for a cut of a distant gradient need not be valid here. Returns the offsets of
  /// that length at which each of them is the highest.
  std::vector<Coordinates> drop_distant(const std::vector<double>& weights, double distance);

  /// Restricts the model to a subspace of at most `carried` dimensions for the cuts that carry the
  /// minimum-norm subgradient of this radius, and `dimension` in all if they need less. There follow the
  /// latest curvature and the cuts that are highest at the last minimiser; what has no room is dropped.
  /// Returns an orthonormal basis of the subspace, by which coordinates are from now on.
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
  /// Drops the cut that is lowest at the last minimiser, if there are as many as the model keeps. That of the
  /// current point stays: without it the model would not interpolate J there.
  void make_room();
  /// g·d − e at the last minimiser d.
  [[nodiscard]] double at_minimiser(const Cut& cut) const;

  BundleOptions options_;
  Curvature curvature_;
  std::vector<Cut> cuts_;      ///< never empty: the first is that of the current point
  Coordinates last_minimiser_; ///< from the current point
};

} // namespace signorini::optimize
