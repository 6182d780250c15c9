// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "drivers/motion_writer.h"
#include "io/manifest.h"
#include "io/output_folder.h"
#include "scene/table.h"

/// Output common to the verbs that write results.
namespace signorini::drivers {

/// Describes extent, mass and wave speeds of the body, for spotting unit errors, with notes and warnings.
/// Collective.
std::string body_lines(const problem::Problem& problem);

/// Describes the size of a problem before its run starts. Collective.
std::string headline(const problem::Problem& problem);

/// Warnings about the tables of a scene's time series; tables that cannot be read are skipped. Collective.
std::vector<scene::TableWarning> series_warnings(MPI_Comm comm, const scene::Scene& scene);
/// Prints warnings about tables.
void print_table_warnings(const std::vector<scene::TableWarning>& warnings, const Console& console);
/// Adds warnings about tables to the warnings of run.json.
void add_table_warnings(io::Manifest& manifest, const std::vector<scene::TableWarning>& warnings);

/// Arranges that a run stores its mesh in its output folder. Sets the path to write in `meshing`, and lets
/// the scene `written`, which is stored with the results, refer to the stored mesh.
void keep_mesh(const io::OutputFolder& folder, mesh::Meshing& meshing, scene::Scene& written);

/// Collects the entries of run.json that are common to all runs. Collective.
io::Manifest manifest(const problem::Problem& problem, const std::string& verb,
                      const std::string& stop_reason, int steps_done);

/// Adds the summary, invariants and warnings of a recorded motion to run.json. Prints the warnings, and the
/// invariants that exceed their limits. Collective.
void add_watched(io::Manifest& manifest, MotionWriter& recorder, const scene::Run& run,
                 const Console& console);

/// Adds a warning, unless absent, to run.json and prints it.
void add_warning(io::Manifest& manifest, std::optional<Warning> warning, const Console& console);

/// Moves the files of a run into its output folder (OutputFolder::publish()), and prints which pages and
/// figures of an earlier run this removed. Throws UserError. Collective.
void finish(io::OutputFolder& folder, const Console& console);

} // namespace signorini::drivers
