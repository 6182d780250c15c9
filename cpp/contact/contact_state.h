// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace signorini::contact {

/// Status of a candidate after a step (docs/method.md section 4); strongly and weakly active candidates form
/// the active set A = S ∪ W.
enum class Status : std::uint8_t {
  open,   ///< g > 0
  weak,   ///< in W: g = 0 and λ = 0
  strong, ///< in S: g = 0 and λ > 0, or g = 0 and linearly dependent on candidates with λ > 0 at its node
};

/// Name of a status as written in tables.
[[nodiscard]] constexpr const char* name(Status status) {
  return status == Status::open ? "open" : status == Status::weak ? "weak" : "strong";
}

/// Largest penetration accepted for a body of the given diameter (both in m).
[[nodiscard]] constexpr double gap_tolerance(double diameter) { return 1e-10 * diameter; }

/// Numbers of the candidates in contact, ascending. A candidate has the same number as its group of
/// constraint rows (ConstraintRows).
using ActiveSet = std::vector<int>;

/// Linear equation E U + F ρ = c that replaces the contact law of a group of k ≤ 3 constraint rows in a
/// Newton step or a linearised step. U are the gaps of the group, ρ its multipliers.
struct LawEquation {
  std::array<double, 9> E{}, F{}; ///< (k × k), row by row
  std::array<double, 3> c{};
};

/// Contact data of a step that the linearised step, the adjoint step and the next step need. They are the
/// same on every rank. The size of the data grows with the number of candidates in contact, not with the
/// number m of all candidates.
struct ContactLinearisation {
  ActiveSet active;           ///< active set A = S ∪ W
  std::vector<double> forces; ///< ρ of all rows of active groups: τ²/2 times the nodal contact forces
  /// Linearised contact laws of the active groups. Empty if all laws are symmetric: then each active group
  /// has zero gap and an arbitrary multiplier.
  std::vector<LawEquation> equations;
  ActiveSet weak{};      ///< weakly active candidates W
  ActiveSet predictor{}; ///< Z: candidates closed at the projected predictor; empty in other schemes
};

/// Contact data of one step for all candidates.
struct ContactState : ContactLinearisation {
  std::vector<double> lambda; ///< multipliers ρ of all constraint rows; the first m rows are the normal ones
  std::vector<double> gap;    ///< gaps U of all constraint rows, m
  std::vector<Status> status; ///< status of each candidate
  int vi_iterations = 0; ///< number of solver iterations that led to the active set; 0 if none was needed

  /// Sets all m candidates to open, with one constraint row per candidate. Reserves memory for every possible
  /// active set, so that steps do not allocate.
  explicit ContactState(int m = 0) : ContactState(m, m) {}
  /// Sets all m candidates to open, with `rows` constraint rows in total.
  ContactState(int m, int rows)
      : lambda(static_cast<std::size_t>(rows)), gap(static_cast<std::size_t>(rows)),
        status(static_cast<std::size_t>(m), Status::open) {
    active.reserve(static_cast<std::size_t>(m));
    forces.reserve(static_cast<std::size_t>(m));
    weak.reserve(static_cast<std::size_t>(m));
    predictor.reserve(static_cast<std::size_t>(m));
  }

  /// Normal multipliers λ_i ≥ 0 of the m candidates: τ²/2 times the normal contact forces.
  [[nodiscard]] std::span<const double> normal_lambda() const {
    return std::span(lambda).first(status.size());
  }
  /// Normal gaps g_i of the m candidates, m.
  [[nodiscard]] std::span<const double> normal_gap() const { return std::span(gap).first(status.size()); }

  /// The part of this state that is kept after the step.
  [[nodiscard]] const ContactLinearisation& linearisation() const { return *this; }

  [[nodiscard]] int count(Status which) const { return static_cast<int>(std::ranges::count(status, which)); }
};

} // namespace signorini::contact
