// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "drivers/motion_writer.h"
#include "io/manifest.h"
#include "io/output_folder.h"
#include "scene/table.h"

/// Output common to the verbs that write results.
namespace signorini::drivers {

/// Extent, mass and wave speeds of the body, for spotting unit errors, with notes and warnings. Collective.
std::string body_lines(const problem::Problem& problem);

/// Describes the run that is about to start. Collective.
std::string headline(const problem::Problem& problem);

/// Warnings about the readable tables of a scene's time series. Collective.
std::vector<scene::TableWarning> series_warnings(MPI_Comm comm, const scene::Scene& scene);
/// Prints warnings about tables.
void print_table_warnings(const std::vector<scene::TableWarning>& warnings, const Console& console);
/// Adds warnings about tables to those of run.json.
void add_table_warnings(io::Manifest& manifest, const std::vector<scene::TableWarning>& warnings);

/// Makes a run keep its mesh in its folder: `meshing` gets the path to write, and the scene `written` with
/// the results refers to it.
void keep_mesh(const io::OutputFolder& folder, mesh::Meshing& meshing, scene::Scene& written);

/// Entries of run.json that are common to all runs. Collective.
io::Manifest manifest(const problem::Problem& problem, const std::string& verb,
                      const std::string& stop_reason, int steps_done);

/// Adds the recorder's sums, invariants and warnings to run.json; prints the warnings, and the invariants
/// beyond their limits. Collective.
void add_watched(io::Manifest& manifest, MotionWriter& recorder, const scene::Run& run,
                 const Console& console);

/// Adds a warning to run.json and prints it.
void add_warning(io::Manifest& manifest, std::optional<Warning> warning, const Console& console);

/// Puts the files of the run in place. Collective. Throws UserError.
void finish(io::OutputFolder& folder, const Console& console);

} // namespace signorini::drivers
