// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"
#include <functional>
#include <map>

namespace signorini::problem {

/// Problems of J for one control space, whose scenes differ in keys of the body, contact, loads or initial
/// states, or not at all. Those with equal step operators D share them and their factorisation, and make
/// their steps together. All members are collective.
class MotionSet {
public:
  /// Starts with the problem of one scene, which is not part of the set but whose operators it shares.
  /// `objective`: of that scene; a desired motion under a reference control is that of this scene. The
  /// references must outlive this object.
  MotionSet(const Problem& first, const control::ControlSpace& controls, const control::Objective& objective);
  ~MotionSet();

  /// Adds the problem of a scene. `motions`: number of motions that divide the budget of checkpoints. Throws
  /// UserError, SolverFailure, Interrupted.
  control::ReducedProblem& add(const scene::Scene& scene, std::size_t motions);

  [[nodiscard]] std::size_t size() const { return parts_.size(); }
  [[nodiscard]] control::ReducedProblem& operator[](std::size_t i);

  /// Runs tasks, each of which computes with another problem of the set or with the first scene's, together
  /// as far as their solvers admit it.
  void run(const std::vector<std::function<void()>>& tasks);

private:
  struct Parts;

  const Problem& first_;
  const control::ControlSpace& controls_;
  const control::Objective& objective_;
  std::vector<std::unique_ptr<Parts>> parts_;
  std::map<std::string, std::vector<const Problem*>> of_operators_; ///< by operators_key()
  Lockstep lockstep_;
};

} // namespace signorini::problem
