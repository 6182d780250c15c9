// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/resume.h"
#include "base/collective.h"
#include "base/error.h"
#include "scene/compatibility.h"
#include "version.h"
#include <cmath>
#include <fmt/format.h>

namespace signorini::drivers::resume {
namespace {

/// Version of the layout of checkpoint.h5.
constexpr int format = 9;

} // namespace

bool found(const io::OutputFolder& folder, const Console& console) {
  int there = 0;
  if (rank(folder.comm()) == 0)
    there = std::filesystem::exists(folder.path() / checkpoint);
  MPI_Bcast(&there, 1, MPI_INT, 0, folder.comm());
  if (!there)
    console.line(fmt::format("no checkpoint in {}: starting from the first guess", folder.path().string()));
  return there != 0;
}

void store_problem(io::CheckpointWriter& out, const std::string& scene, const mesh::Mesh& mesh) {
  out("format", format);
  out("program", std::string("signorini ") + SIGNORINI_VERSION);
  out("scene", scene);
  out("mesh", mesh.digest());
}

void require_same_problem(io::CheckpointReader& in, const std::string& scene, const mesh::Mesh& mesh) {
  int layout = 0;
  in("format", layout);
  if (layout != format)
    in.fail(
        fmt::format("found file layout {}, but this version of signorini reads layout {}; start the search "
                    "again, without --resume",
                    layout, format));
  std::string stored;
  in("scene", stored);
  const scene::Difference difference = scene::difference(stored, scene, scene::Part::search);
  if (!difference.first.empty())
    in.fail(fmt::format("found a run with {}, this scene has "
                        "{}; resume with the scene of the interrupted run",
                        difference.first, difference.second));
  in("mesh", stored);
  int same = rank(mesh.comm()) != 0 || stored == mesh.digest();
  MPI_Bcast(&same, 1, MPI_INT, 0, mesh.comm());
  if (!same)
    in.fail("found a run on another mesh, whose nodes, elements or groups differ; resume with the mesh of "
            "the interrupted run");
}

void require_same_value(const std::filesystem::path& file, double stored, double found, double scale) {
  constexpr double other_ranks = 1e-6;
  if (!(std::abs(found - stored) <= other_ranks * scale))
    throw UserError(fmt::format("--resume: {}: J at the stored point is now {:.10g}, but was {:.10g}; resume "
                                "with the forms and data of the interrupted run",
                                file.string(), found, stored));
}

std::string not_written(const std::filesystem::path& file, const std::string& failure) {
  return fmt::format("warning: {} was not written ({}); the run continues, and an earlier checkpoint remains "
                     "in place",
                     file.string(), failure);
}

} // namespace signorini::drivers::resume
