// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "io/checkpoint.h"
#include "io/output_folder.h"
#include "mesh/mesh.h"
#include <filesystem>
#include <string>

/// Conditions under which --resume continues a search of any kind: its checkpoint is whole, its scene poses
/// the same problem, and J at its point is unchanged.
namespace signorini::drivers::resume {

constexpr const char* checkpoint = "checkpoint.h5"; ///< file name

/// Whether the folder has a checkpoint; prints a line if not. Collective.
[[nodiscard]] bool found(const io::OutputFolder& folder, const Console& console);

/// Stores the layout of checkpoints and the problem; `scene`: the scene's echo().
void store_problem(io::CheckpointWriter& out, const std::string& scene, const mesh::Mesh& mesh);

/// Throws UserError if the checkpoint has another layout or another mesh, or if its scene poses another
/// problem to a search. Collective.
void require_same_problem(io::CheckpointReader& in, const std::string& scene, const mesh::Mesh& mesh);

/// Throws UserError if J at the restored point differs from the stored J, relative to `scale`, by more than
/// another number of ranks explains: then forms or data have changed.
void require_same_value(const std::filesystem::path& file, double stored, double found, double scale);

/// Warning that a checkpoint could not be written.
[[nodiscard]] std::string not_written(const std::filesystem::path& file, const std::string& failure);

} // namespace signorini::drivers::resume
