// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "drivers/motion_writer.h"
#include "io/manifest.h"
#include "io/output_folder.h"
#include "scene/table.h"

/// Output common to the verbs that write results.
namespace signorini::drivers {

/// The body in figures, and what is implausible about it. Collective.
std::string body_lines(const problem::Problem& problem);

/// The run about to be made, in words. Collective.
std::string headline(const problem::Problem& problem);

/// Doubts about the tables that a scene reads its time series from, as far as they can be read. Collective.
std::vector<scene::TableWarning> series_warnings(MPI_Comm comm, const scene::Scene& scene);
/// Prints warnings about tables.
void print_table_warnings(const std::vector<scene::TableWarning>& warnings, const Console& console);
/// Adds them to the warnings of run.json.
void add_table_warnings(io::Manifest& manifest, const std::vector<scene::TableWarning>& warnings);

/// Keeps the mesh of a run in its folder: `meshing` writes it, and the scene that is `written` names it.
void keep_mesh(const io::OutputFolder& folder, mesh::Meshing& meshing, scene::Scene& written);

/// The part of run.json that is common to all runs. Collective.
io::Manifest manifest(const problem::Problem& problem, const std::string& verb,
                      const std::string& stop_reason, int steps_done);

/// Adds the recorder's sums, invariants and warnings to run.json and prints the latter two where they are
/// beyond their limits. Collective.
void add_watched(io::Manifest& manifest, MotionWriter& recorder, const scene::Run& run,
                 const Console& console);

/// Adds a warning to run.json and prints it.
void add_warning(io::Manifest& manifest, std::optional<Warning> warning, const Console& console);

/// Puts the files in place. Collective. Throws UserError.
void finish(io::OutputFolder& folder, const Console& console);

} // namespace signorini::drivers
