// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "fem/stress_recovery.h"
#include <vector>

namespace signorini::diagnostics {

/// The name of the warning of a largest stress that is of its mesh.
constexpr const char* stress_of_the_mesh = "stress of the mesh";

/// The largest von Mises stress of a motion, and whether the mesh resolves it: a stress at a sharp corner
/// grows without bound as the mesh is refined, and the cells around it then differ much from it.
class LargestStress {
public:
  struct Peak {
    fem::StressPeak stress;
    double time = 0; ///< s
  };

  /// Of a body of these parts. Collective. `space` must outlive this object.
  LargestStress(const fem::Space& space, std::vector<fem::Part> parts);

  /// Takes the motion at time `t` (s), which was the last one set in `fields`. Collective.
  void observe(fem::CellFields& fields, Vec y, Vec v, double t);

  /// Absent before a motion was observed. Collective.
  [[nodiscard]] std::optional<Peak> peak();

  /// A warning that names the corner. Collective.
  [[nodiscard]] std::vector<Warning> warnings();

private:
  const fem::Space& space_;
  std::vector<fem::Part> parts_;
  petsc::Vector y_, v_; ///< at the largest so far
  double largest_ = -1, time_ = 0;
  std::optional<Peak> peak_; ///< of that, once it was asked for
};

} // namespace signorini::diagnostics
