// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include "step/step.h"
#include <array>
#include <string>
#include <vector>

namespace signorini::diagnostics {

/// Extent, mass and wave speeds of the body, for spotting unit errors.
struct BodyFigures {
  std::array<double, 3> extent{}; ///< extent of the bounding box, m
  int dim = 0;                    ///< dimension, 2 or 3
  std::string model;              ///< model of a body in the plane, mesh.model; "space" in space
  std::string per_depth{};        ///< suffix of the units of mass, force and energy, scene::per_depth()
  double mass = 0;                ///< kg, with the suffix per_depth
  std::array<double, 2> pressure_waves{}; ///< least and greatest speed over the materials, m/s
  std::array<double, 2> shear_waves{};    ///< least and greatest speed over the materials, m/s
  double crossing = 0;                    ///< time in which the fastest wave crosses the greatest extent, s
  double crossing_steps = 0;              ///< number of time steps in that time; 0: automatic steps
  std::vector<std::string> warnings;      ///< implausible figures, one sentence each
  std::vector<std::string> notes; ///< notes on how the mesh was read, one sentence each; on rank 0 only

  /// Returns the figures as a line of text, without the warnings.
  [[nodiscard]] std::string line() const;
};

/// Returns extent, mass, wave speeds and warnings of a scene's undeformed body. Collective.
BodyFigures body_figures(const step::Stepper& stepper, const scene::Scene& scene);

} // namespace signorini::diagnostics
