#pragma once
#include "base/dense.h"
#include "optimize/span.h"

namespace signorini::optimize {

/// A symmetric positive definite approximation B of the Hessian from pairs of directions and their Hessian
/// products, B D = Y, with the least curvature σ among these on the complement:
///     B = σ (I − D (DᵀD)⁻¹ Dᵀ) + Y (DᵀY)⁻¹ Yᵀ
class Curvature {
public:
  /// Adds the pair H d = y, d·y > 0.
  void learn(const Coordinates& d, const Coordinates& y) {
    const double curvature = dot(d, y) / dot(d, d);
    least_ = known_.empty() ? curvature : std::min(least_, curvature);
    largest_ = std::max(largest_, norm(y) / norm(d));
    known_.emplace_back(d, y);
  }

  /// The largest ‖y‖/‖d‖ of the pairs, at least their largest curvature; 1 without any.
  [[nodiscard]] double largest() const { return largest_ > 0 ? largest_ : 1; }
  [[nodiscard]] bool empty() const { return known_.empty(); }
  void forget_oldest() { known_.erase(known_.begin()); }

  /// B (n × n). Throws SolverFailure if DᵀD or DᵀY is not positive definite.
  [[nodiscard]] std::vector<double> matrix(std::size_t n) const {
    std::vector<double> B(n * n);
    for (std::size_t i = 0; i < n; ++i)
      B[i * n + i] = least_;
    const std::size_t k = known_.size();
    std::vector<double> DD(k * k), DY(k * k), D(n * k), Y(n * k);
    for (std::size_t i = 0; i < k; ++i) {
      const auto& [d, y] = known_[i];
      for (std::size_t j = 0; j < k; ++j) {
        DD[i * k + j] = dot(d, known_[j].first);
        DY[i * k + j] = (dot(d, known_[j].second) + dot(known_[j].first, y)) / 2;
      }
      for (std::size_t c = 0; c < d.size(); ++c)
        D[c * k + i] = d[c];
      for (std::size_t c = 0; c < y.size(); ++c)
        Y[c * k + i] = y[c];
    }
    std::vector<double> by_DD = D, by_DY = Y;
    solve_dense(DD, by_DD);
    solve_dense(DY, by_DY);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        for (std::size_t l = 0; l < k; ++l)
          B[i * n + j] += Y[i * k + l] * by_DY[j * k + l] - least_ * D[i * k + l] * by_DD[j * k + l];
    return B;
  }

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
