// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
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

/// Contact of a step as its derivative and the next step depend on it, the same on every rank. It grows with
/// the number of candidates in contact, not with m.
struct ContactLinearisation {
  ActiveSet active;           ///< A = S ∪ W
  std::vector<double> forces; ///< λ_i of these, τ²/2 times the nodal contact forces
  ActiveSet weak;             ///< W
  ActiveSet predictor;        ///< Z: candidates that the projected predictor touches; contact-stabilized only

  /// λ of all candidates, zero off the active set.
  void spread(std::span<double> lambda) const {
    std::ranges::fill(lambda, 0);
    for (std::size_t j = 0; j < active.size(); ++j)
      lambda[static_cast<std::size_t>(active[j])] = forces[j];
  }
};

/// Contact after one step; arrays over all m candidates.
struct ContactState : ContactLinearisation {
  std::vector<double> lambda; ///< λ_i ≥ 0: τ²/2 times the nodal contact force
  std::vector<double> gap;    ///< g_i, m
  std::vector<Status> status;
  int vi_iterations = 0; ///< (primal-dual) Newton steps that found the active set; 0 if it was right at once

  /// All m candidates open. Reserves room for every active set, so that steps do not allocate.
  explicit ContactState(int m = 0)
      : lambda(static_cast<std::size_t>(m)), gap(static_cast<std::size_t>(m)),
        status(static_cast<std::size_t>(m), Status::open) {
    active.reserve(static_cast<std::size_t>(m));
    forces.reserve(static_cast<std::size_t>(m));
    weak.reserve(static_cast<std::size_t>(m));
    predictor.reserve(static_cast<std::size_t>(m));
  }

  /// What outlives the step.
  [[nodiscard]] const ContactLinearisation& linearisation() const { return *this; }

  [[nodiscard]] int count(Status which) const { return static_cast<int>(std::ranges::count(status, which)); }
};

} // namespace signorini::contact
