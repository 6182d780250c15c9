#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

namespace signorini::contact {

/// Status of a candidate after a step, method.md section 4: A = S ∪ W.
enum class Status : std::uint8_t {
  open,   ///< g > 0
  weak,   ///< W: g = 0 and λ = 0
  strong, ///< S: g = 0 and λ > 0
};

/// Numbers of the candidates in contact, ascending.
using ActiveSet = std::vector<int>;

/// Contact after one step; arrays over all m candidates, the same on every rank.
struct ContactState {
  std::vector<double> lambda; ///< λ_i ≥ 0: τ²/2 times the nodal contact force
  std::vector<double> gap;    ///< g_i, m
  std::vector<Status> status;
  int vi_iterations = 0; ///< Newton steps of the VI solver; 0 where it was not needed

  [[nodiscard]] int count(Status which) const {
    return static_cast<int>(std::ranges::count(status, which));
  }
  /// A = S ∪ W.
  [[nodiscard]] ActiveSet active() const {
    ActiveSet set;
    for (std::size_t i = 0; i < status.size(); ++i)
      if (status[i] != Status::open)
        set.push_back(static_cast<int>(i));
    return set;
  }
};

} // namespace signorini::contact
