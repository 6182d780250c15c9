// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include <span>
#include <utility>

namespace signorini::step {

/// The state of a motion, or of a linearised one, at one time: vectors of V, of which the first is the
/// displacement y (m) and the second the velocity v (m/s). What stores or moves states handles all parts
/// alike.
class State {
public:
  /// Without parts.
  State() = default;
  /// `parts` of them, zero, in the layout of `like`. Collective.
  State(Vec like, std::size_t parts) : parts_(petsc::zero_series(like, parts)) {}

  [[nodiscard]] Vec y() const { return parts_[0]; }
  [[nodiscard]] Vec v() const { return parts_[1]; }
  [[nodiscard]] std::span<const petsc::Vector> parts() const { return parts_; }

  /// Copies the parts that this state has from `other`, which has them all. Collective.
  void copy(const State& other) {
    for (std::size_t i = 0; i < parts_.size(); ++i)
      petsc::check(VecCopy(other.parts_[i], parts_[i]));
  }

private:
  petsc::Series parts_;
};

/// What a backward sweep carries from step k + 1 to step k (docs/method.md section 4).
struct AdjointState {
  petsc::Vector p, p_next; ///< p_k, a guess before step k, and p_{k+1}
  petsc::Vector omega;     ///< ω_{k+1}, after step k ω_k

  /// Zero, as behind step N. Collective.
  explicit AdjointState(Vec like)
      : p(petsc::zero_like(like)), p_next(petsc::zero_like(like)), omega(petsc::zero_like(like)) {}

  /// Moves on to step k − 1.
  void advance() { std::swap(p, p_next); }
};

} // namespace signorini::step
