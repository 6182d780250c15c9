// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <array>
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

/// The status as tables have it.
[[nodiscard]] constexpr const char* name(Status status) {
  return status == Status::open ? "open" : status == Status::weak ? "weak" : "strong";
}

/// The largest penetration allowed of a body of a diameter, m.
[[nodiscard]] constexpr double gap_tolerance(double diameter) { return 1e-10 * diameter; }

/// Numbers of the candidates in contact, ascending.
using ActiveSet = std::vector<int>;

/// A linear equation E U + F ρ = c between the gaps and multipliers of a group of k ≤ 3 rows, in place of
/// its law.
struct LawEquation {
  std::array<double, 9> E{}, F{}; ///< (k × k), row by row
  std::array<double, 3> c{};
};

/// Contact of a step as its derivative and the next step depend on it, the same on every rank. It grows with
/// the number of candidates in contact, not with m.
struct ContactLinearisation {
  ActiveSet active;           ///< A = S ∪ W
  std::vector<double> forces; ///< ρ of these groups' rows, τ²/2 times the nodal contact forces
  /// The linearised laws of these; empty if all laws are symmetric, λ free and g = 0.
  std::vector<LawEquation> equations;
  ActiveSet weak{};      ///< W
  ActiveSet predictor{}; ///< Z: candidates that the projected predictor touches; contact-stabilized only
};

/// Contact after one step.
struct ContactState : ContactLinearisation {
  std::vector<double> lambda; ///< ρ of the rows of constraints, of which the first m are the normals
  std::vector<double> gap;    ///< U of these rows, m
  std::vector<Status> status; ///< of candidates
  int vi_iterations = 0; ///< (primal-dual) Newton steps that found the active set; 0 if it was right at once

  /// All m candidates open, with one row each. Reserves room for every active set, so that steps do not
  /// allocate.
  explicit ContactState(int m = 0) : ContactState(m, m) {}
  /// With so many rows in all.
  ContactState(int m, int rows)
      : lambda(static_cast<std::size_t>(rows)), gap(static_cast<std::size_t>(rows)),
        status(static_cast<std::size_t>(m), Status::open) {
    active.reserve(static_cast<std::size_t>(m));
    forces.reserve(static_cast<std::size_t>(m));
    weak.reserve(static_cast<std::size_t>(m));
    predictor.reserve(static_cast<std::size_t>(m));
  }

  /// λ_i ≥ 0 of the m candidates, τ²/2 times the normal contact forces.
  [[nodiscard]] std::span<const double> normal_lambda() const {
    return std::span(lambda).first(status.size());
  }
  /// Their gaps g_i, m.
  [[nodiscard]] std::span<const double> normal_gap() const { return std::span(gap).first(status.size()); }

  /// What outlives the step.
  [[nodiscard]] const ContactLinearisation& linearisation() const { return *this; }

  [[nodiscard]] int count(Status which) const { return static_cast<int>(std::ranges::count(status, which)); }
};

} // namespace signorini::contact
