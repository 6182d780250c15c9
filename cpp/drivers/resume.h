// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "io/checkpoint.h"
#include "io/output_folder.h"
#include "mesh/mesh.h"
#include <filesystem>
#include <string>

/// Checks before --resume continues a search: the checkpoint is undamaged, its scene defines the same
/// problem, and J at the stored point is unchanged.
namespace signorini::drivers::resume {

constexpr const char* checkpoint = "checkpoint.h5"; ///< file name of checkpoints

/// Whether the folder has a checkpoint; prints a line if it has none. Collective.
[[nodiscard]] bool found(const io::OutputFolder& folder, const Console& console);

/// Writes the version of the checkpoint layout, the scene and the mesh into a checkpoint. `scene`: text of
/// the resolved scene (echo()). Collective.
void store_problem(io::CheckpointWriter& out, const std::string& scene, const mesh::Mesh& mesh);

/// Throws UserError if a checkpoint has another layout version than this program writes, another mesh than
/// `mesh`, or a scene that differs from `scene` in keys that define the problem or the search. Collective.
void require_same_problem(io::CheckpointReader& in, const std::string& scene, const mesh::Mesh& mesh);

/// Throws UserError if J at the restored point, `found`, differs from `stored` by more than a change of the
/// number of ranks explains, relative to `scale`. Such a difference means that files or the program changed.
void require_same_value(const std::filesystem::path& file, double stored, double found, double scale);

/// Message that a checkpoint could not be written. `failure`: the reason.
[[nodiscard]] std::string not_written(const std::filesystem::path& file, const std::string& failure);

} // namespace signorini::drivers::resume
