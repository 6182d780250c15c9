// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/step.h"
#include <array>
#include <string>
#include <vector>

namespace signorini::diagnostics {

/// The body in figures by which a wrong unit shows.
struct BodyFigures {
  std::array<double, 3> extent{};         ///< of its bounding box, m
  int dim = 0;                            ///< of these, 2 or 3
  double mass = 0;                        ///< kg, in the plane kg/m
  std::array<double, 2> pressure_waves{}; ///< least and greatest speed over the materials, m/s
  std::array<double, 2> shear_waves{};    ///< likewise
  double crossing = 0;               ///< time in which the fastest wave comes across the greatest extent, s
  double crossing_steps = 0;         ///< time steps in it; 0: their length varies
  std::vector<std::string> warnings; ///< what is implausible, one sentence each
  std::vector<std::string> notes;    ///< how the mesh was understood, likewise; on rank 0 only

  /// In words, without the warnings.
  [[nodiscard]] std::string line() const;
};

/// Of the undeformed body of a scene. Collective.
BodyFigures body_figures(const step::Stepper& stepper, const scene::Scene& scene);

} // namespace signorini::diagnostics
