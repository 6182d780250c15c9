// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "diagnostics/obstacle_forces.h"
#include "scene/scene.h"
#include <span>
#include <string>

/// The CSV files of a run with a row for each step and obstacle, or for each step, as text.
namespace signorini::io {

/// Header of obstacles.csv: one row per step and obstacle, step 0 the initial state.
std::string obstacles_header(int dim);

/// Appends the rows of step k. `contacts`: those of the scene, which have the obstacles' names.
void add_obstacle_rows(std::string& text, int k, double time, int dim,
                       const std::vector<scene::Contact>& contacts,
                       const diagnostics::ObstacleForces& forces);

/// Header of probes.csv: one row per step, row 0 the initial state.
std::string probes_header(const std::vector<std::string>& columns);

/// Appends row k.
void add_probes_row(std::string& text, int k, double time, std::span<const double> values);

} // namespace signorini::io
