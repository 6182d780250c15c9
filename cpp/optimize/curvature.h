// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/span.h"
#include "optimize/unknowns.h"
#include <optional>
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

} // namespace signorini::optimize
