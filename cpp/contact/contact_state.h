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
  strong, ///< S: g = 0 and λ > 0, its own or, if linearly dependent, that of others of its node
};

/// Name of a status in tables.
[[nodiscard]] constexpr const char* name(Status status) {
  return status == Status::open ? "open" : status == Status::weak ? "weak" : "strong";
}

/// Largest penetration allowed for a body of the given diameter, m.
[[nodiscard]] constexpr double gap_tolerance(double diameter) { return 1e-10 * diameter; }

/// Numbers of the candidates in contact, ascending.
using ActiveSet = std::vector<int>;

/// A linear equation E U + F ρ = c between the gaps and multipliers of a group of k ≤ 3 rows, in place of
/// its law.
struct LawEquation {
  std::array<double, 9> E{}, F{}; ///< (k × k), row by row
  std::array<double, 3> c{};
};

/// Contact data of a step on which its derivative and the next step depend, the same on every rank. Its size
/// grows with the number of candidates in contact, not with m.
struct ContactLinearisation {
  ActiveSet active;           ///< A = S ∪ W
  std::vector<double> forces; ///< ρ of the active groups' rows, τ²/2 times the nodal contact forces
  /// Linearised laws of the active groups; empty if all laws are symmetric (λ free, g = 0).
  std::vector<LawEquation> equations;
  ActiveSet weak{};      ///< W
  ActiveSet predictor{}; ///< Z: candidates that the projected predictor touches; contact-stabilized only
};

/// Contact after one step.
struct ContactState : ContactLinearisation {
  std::vector<double> lambda; ///< ρ of all constraint rows; the first m rows are the normals
  std::vector<double> gap;    ///< U of all constraint rows, m
  std::vector<Status> status; ///< status of each candidate
  int vi_iterations = 0; ///< (primal-dual) Newton steps to find the active set; 0 if the first one was right

  /// Sets all m candidates open, with one row each. Reserves room for every active set, so that steps do not
  /// allocate.
  explicit ContactState(int m = 0) : ContactState(m, m) {}
  /// Sets all m candidates open, with `rows` constraint rows in all.
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
  /// Gaps g_i of the m candidates, in metres.
  [[nodiscard]] std::span<const double> normal_gap() const { return std::span(gap).first(status.size()); }

  /// The part that outlives the step.
  [[nodiscard]] const ContactLinearisation& linearisation() const { return *this; }

  [[nodiscard]] int count(Status which) const { return static_cast<int>(std::ranges::count(status, which)); }
};

} // namespace signorini::contact
