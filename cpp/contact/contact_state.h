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

/// Motion of a candidate along the obstacle in a step.
enum class Motion : std::uint8_t {
  open,   ///< not in contact
  free,   ///< in contact without friction
  sticks, ///< with friction, at rest relative to the obstacle
  slips,  ///< with friction that has reached its bound; moves along the obstacle
};

/// Name of a motion as written in tables.
[[nodiscard]] constexpr const char* name(Motion motion) {
  constexpr std::array names{"open", "free", "stick", "slip"};
  return names[static_cast<std::size_t>(motion)];
}

/// Largest penetration accepted for a body of the given diameter (both in m).
[[nodiscard]] constexpr double gap_tolerance(double diameter) { return 1e-10 * diameter; }

/// Numbers of the candidates in contact, ascending. A candidate has the same number as its group of
/// constraint rows (ConstraintRows).
using ActiveSet = std::vector<int>;

/// Linear equation E U + F ρ = c that replaces the contact law of a group of k ≤ 3 constraint rows in a
/// Newton step or a linearised step. U are the gaps of the group, ρ its multipliers.
struct LawEquation {
  std::array<double, 9> E{}, F{};   ///< (k × k), row by row
  std::array<double, 3> constant{}; ///< c; zero in linearised steps
  Motion motion = Motion::free;
  double friction = 0; ///< as ContactState::friction
  bool closed = true;  ///< whether the candidate is in contact; false only if its law acts without contact
  bool weak = false;   ///< whether the candidate is in contact without normal force: it is about to open
  bool limit = false;  ///< whether the candidate sticks with the largest friction: it is about to slip

  /// Replaces the normal row by λ = 0. `compliance`: change of the normal gap per unit of λ.
  void open(double compliance) {
    E[0] = 0;
    F[0] = compliance;
    closed = false;
  }
};

/// Contact data of a step that the linearised step, the adjoint step and the next step need. They are the
/// same on every rank. The size of the data grows with the number of candidates in contact, not with the
/// number m of all candidates.
struct ContactLinearisation {
  /// Candidates with multipliers and equations: A = S ∪ W and, with Tresca friction, which acts without
  /// contact, all of its candidates. Those in contact are closed_set().
  ActiveSet active;
  std::vector<double> forces; ///< ρ of all rows of active groups: τ²/2 times the nodal contact forces
  /// Linearised contact laws of the active groups. Empty if all laws are symmetric: then each active group
  /// has zero gap and an arbitrary multiplier.
  std::vector<LawEquation> equations;
  /// Candidates at which the law has a kink: weakly active ones, W, and those that are about to slip.
  ActiveSet weak{};
  ActiveSet predictor{}; ///< Z: candidates closed at the projected predictor; empty in other schemes
  /// Candidates of Z at which the projection of the predictor has a kink: they touch there without a
  /// multiplier of the projection, and are in W or arrived in this step.
  ActiveSet predictor_weak{};

  /// Number of candidates at which the step or its predictor has a kink.
  [[nodiscard]] std::size_t kinks() const {
    return weak.size() + static_cast<std::size_t>(std::ranges::count_if(
                             predictor_weak, [this](int i) { return !std::ranges::binary_search(weak, i); }));
  }

  /// Whether the candidate active[j] is in contact.
  [[nodiscard]] bool closed(std::size_t j) const { return equations.empty() || equations[j].closed; }
  /// Candidates in contact, ascending: S ∪ W.
  [[nodiscard]] ActiveSet closed_set() const {
    ActiveSet set;
    for (std::size_t j = 0; j < active.size(); ++j)
      if (closed(j))
        set.push_back(active[j]);
    return set;
  }
  /// Motion of the candidate active[j] along its obstacle.
  [[nodiscard]] Motion motion(std::size_t j) const {
    return equations.empty() ? Motion::free : equations[j].motion;
  }
};

/// Contact data of one step for all candidates.
struct ContactState : ContactLinearisation {
  std::vector<double> lambda; ///< multipliers ρ of all constraint rows; the first m rows are the normal ones
  std::vector<double> gap;    ///< gaps U of all constraint rows, m
  std::vector<Status> status; ///< status of each candidate
  /// Friction of each candidate in this step, an input of the step: the coefficient of Coulomb friction, or
  /// the bound of the tangential multiplier in Tresca friction, τ²/2 times that of the force. Empty without
  /// friction.
  std::vector<double> friction{};
  /// On rank 0: whether the laws of the step have at least two other solutions, which friction can cause.
  bool several = false;
  int vi_iterations = 0; ///< number of solver iterations that led to the active set; 0 if none was needed

  /// Sets all m candidates to open, with one constraint row per candidate. Reserves memory for every possible
  /// active set, so that steps do not allocate.
  explicit ContactState(int m = 0) : ContactState(m, m) {}
  /// Sets all m candidates to open, with `rows` constraint rows in total.
  ContactState(int m, int rows)
      : lambda(static_cast<std::size_t>(rows)), gap(static_cast<std::size_t>(rows)),
        status(static_cast<std::size_t>(m), Status::open) {
    active.reserve(static_cast<std::size_t>(m));
    forces.reserve(static_cast<std::size_t>(rows));
    if (rows > m)
      equations.reserve(static_cast<std::size_t>(m));
    weak.reserve(static_cast<std::size_t>(m));
    predictor.reserve(static_cast<std::size_t>(m));
    predictor_weak.reserve(static_cast<std::size_t>(m));
  }

  /// Normal multipliers λ_i ≥ 0 of the m candidates: τ²/2 times the normal contact forces.
  [[nodiscard]] std::span<const double> normal_lambda() const {
    return std::span(lambda).first(status.size());
  }
  /// Normal gaps g_i of the m candidates, m.
  [[nodiscard]] std::span<const double> normal_gap() const { return std::span(gap).first(status.size()); }
  /// Friction of a candidate, as above; 0 without friction.
  [[nodiscard]] double friction_of(std::size_t i) const { return friction.empty() ? 0 : friction[i]; }

  /// The part of this state that is kept after the step.
  [[nodiscard]] const ContactLinearisation& linearisation() const { return *this; }

  [[nodiscard]] int count(Status which) const { return static_cast<int>(std::ranges::count(status, which)); }
  /// Number of active candidates with a motion; 0 if no candidate has friction.
  [[nodiscard]] int count(Motion which) const {
    return static_cast<int>(std::ranges::count(equations, which, &LawEquation::motion));
  }
  /// Motions of all candidates.
  [[nodiscard]] std::vector<Motion> motions() const {
    std::vector<Motion> all(status.size(), Motion::open);
    for (std::size_t j = 0; j < active.size(); ++j)
      all[static_cast<std::size_t>(active[j])] = motion(j);
    return all;
  }
};

} // namespace signorini::contact
