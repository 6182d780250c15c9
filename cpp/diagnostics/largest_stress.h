// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "fem/stress_recovery.h"
#include "step/step.h"
#include <optional>
#include <vector>

namespace signorini::diagnostics {

/// Name of the warning that the largest stress depends on the mesh.
constexpr const char* stress_of_the_mesh = "stress of the mesh";

/// Largest ratio of the largest stress or strain to that of the cells around it on a mesh that resolves it.
constexpr double resolved = 1.3;

/// Finds the largest von Mises stress of a motion, and checks whether the mesh resolves it. The mesh does not
/// if the stresses of neighbouring cells are much smaller. An example is a sharp corner, where the stress
/// grows without bound as the mesh is refined.
class LargestStress {
public:
  /// Largest stress and its time.
  struct Peak {
    fem::StressPeak stress;
    double time = 0; ///< time of the stress, s
  };

  /// Prepares the search in a body that consists of `parts`. `space` must outlive this object.
  LargestStress(const fem::Space& space, std::vector<fem::Part> parts);

  /// Takes the state at time `t` (s), which must be the state set last in `fields`. Collective.
  void observe(fem::CellFields& fields, const step::State& state, double t);

  /// Returns the largest stress so far; nothing before the first state. Collective.
  [[nodiscard]] std::optional<Peak> peak();

  /// Returns a warning if the mesh does not resolve the largest stress; it names the corner at which the
  /// stress occurs, if there is one. Collective.
  [[nodiscard]] std::vector<Warning> warnings();

private:
  const fem::Space& space_;
  std::vector<fem::Part> parts_;
  std::optional<step::State> state_; ///< state of the largest stress so far; absent before the first state
  double largest_ = -1, time_ = 0;
  std::optional<Peak> peak_; ///< peak of state_, once computed
};

} // namespace signorini::diagnostics
