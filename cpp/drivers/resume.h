// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "io/checkpoint.h"
#include "io/output_folder.h"
#include "mesh/mesh.h"
#include <filesystem>
#include <string>

/// The condition under which --resume continues a search, the same for every kind of search: its checkpoint
/// is whole, its scene poses the same problem, and J at its point is as it was.
namespace signorini::drivers::resume {

constexpr const char* checkpoint = "checkpoint.h5"; ///< the file's name

/// Whether the folder has a checkpoint; says so if not. Collective.
[[nodiscard]] bool found(const io::OutputFolder& folder, const Console& console);

/// Stores the layout of checkpoints and the problem: `scene` is its echo().
void store_problem(io::CheckpointWriter& out, const std::string& scene, const mesh::Mesh& mesh);

/// Throws UserError if the checkpoint has another layout, a scene that poses another problem to a search, or
/// another mesh. Collective.
void require_same_problem(io::CheckpointReader& in, const std::string& scene, const mesh::Mesh& mesh);

/// Throws UserError if J at the restored point differs from the stored J by more than another number of ranks
/// explains, relative to `scale`: then forms or data are others.
void require_same_value(const std::filesystem::path& file, double stored, double found, double scale);

/// The warning of a checkpoint that could not be written.
[[nodiscard]] std::string not_written(const std::filesystem::path& file, const std::string& failure);

} // namespace signorini::drivers::resume
