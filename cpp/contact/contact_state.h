// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

namespace signorini::contact {

/// Status of a candidate after a step, docs/method.md section 4: A = S ∪ W.
enum class Status : std::uint8_t {
  open,   ///< g > 0
  weak,   ///< W: g = 0 and λ = 0
  strong, ///< S: g = 0 and λ > 0; where it depends on others of its node, their λ counts too
};

/// Numbers of the candidates in contact, ascending.
using ActiveSet = std::vector<int>;

/// The active sets, on which a step's derivative and the next step depend, the same on every rank. They grow
/// with the number of candidates in contact, not with m.
struct ContactSets {
  ActiveSet active;    ///< A = S ∪ W
  ActiveSet weak;      ///< W
  ActiveSet predictor; ///< Z: candidates that the projected predictor touches; contact-stabilized only
};

/// Contact after one step; arrays over all m candidates.
struct ContactState : ContactSets {
  std::vector<double> lambda; ///< λ_i ≥ 0: τ²/2 times the nodal contact force
  std::vector<double> gap;    ///< g_i, m
  std::vector<Status> status;
  int vi_iterations = 0; ///< (primal-dual) Newton steps that found the active set; 0 if it was right at once

  /// All m candidates open. Reserves room for every active set, so that steps do not allocate.
  explicit ContactState(int m = 0)
      : lambda(static_cast<std::size_t>(m)), gap(static_cast<std::size_t>(m)),
        status(static_cast<std::size_t>(m), Status::open) {
    active.reserve(static_cast<std::size_t>(m));
    weak.reserve(static_cast<std::size_t>(m));
    predictor.reserve(static_cast<std::size_t>(m));
  }

  [[nodiscard]] int count(Status which) const { return static_cast<int>(std::ranges::count(status, which)); }
};

} // namespace signorini::contact
