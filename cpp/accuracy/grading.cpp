// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/grading.h"
#include "accuracy/error_estimate.h"
#include "accuracy/measure.h"
#include "base/collective.h"
#include "base/error.h"
#include "drivers/check/evaluation_point.h"
#include "fem/stress_recovery.h"
#include "mesh/gmsh_process.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <numbers>

namespace signorini::accuracy {

namespace {

/// A mesh with error indicators of its cells, the same on every rank.
struct Indicated {
  mesh::SizeField mesh;
  std::vector<double> error; ///< share of each cell in the error
  double extent;             ///< longest side of the body, m
};

Indicated by_objective(problem::Problem& problem) {
  const Console silent(false, false);
  problem::choose_steps(problem, silent);
  problem::ControlProblem control_problem(problem, silent);
  std::string where;
  (void)control_problem.reduced.value(drivers::evaluation_point(problem, control_problem, where));
  control_problem.reduced.accept();
  std::vector<double> own;
  (void)estimate_error(problem, control_problem, &own);
  Indicated found{.mesh{}, .error{}, .extent = std::ranges::max(problem.mesh.extent())};
  found.mesh = mesh::gather_cells(problem.mesh, own, found.error);
  return found;
}

Indicated by_stress(problem::Problem& problem) {
  fem::StressRecovery recovery(problem.space, fem::parts(problem.mesh, problem.scene.materials));
  const problem::GivenControl given(problem);
  simulate(problem, given.load(), [&](const trajectory::Frame& frame) {
    if (frame.step.k > 0)
      recovery.add(frame.after.y(), frame.step.tau);
  });
  return {recovery.mesh(), recovery.sums(), std::ranges::max(problem.mesh.extent())};
}

/// Computes error indicators on the mesh with the given sizes; null: on the scene's mesh.
Indicated indicated(MPI_Comm comm, const scene::Scene& scene, const mesh::SizeField* sizes) {
  Timers timers;
  const mesh::Meshing meshing{.sizes = sizes, .keep{}};
  problem::Problem problem(std::make_shared<const problem::SpaceDiscretisation>(comm, scene, timers, meshing),
                           scene, problem::study_needs(scene), timers);
  return scene.objective ? by_objective(problem) : by_stress(problem);
}

} // namespace

void write_graded(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& file,
                  const Console& console) {
  if (scene.mesh.format() == scene::MeshFormat::shape)
    throw UserError(
        fmt::format("mesh.file: {} is a CAD file, whose sizes cannot be graded by the error; use a .geo that "
                    "merges it and names its groups",
                    scene.mesh.file.string()));
  scene::Scene coarse = scene;
  coarse.mesh.size = 0; // "auto": ten elements across the body
  coarse.mesh.scale = 1;
  coarse.mesh.degree = 1;
  constexpr double first_reach = 3, reach = 50; // a coarse mesh predicts little of one much finer
  constexpr double around = 1.5; // largest ratio of elements at a curved boundary to the scene's own
  const Indicated first = indicated(comm, coarse, nullptr);
  const mesh::SizeField finer =
      mesh::sizes_by(first.mesh, first.error, 1 / (first_reach * first_reach), first_reach);
  const Indicated second = indicated(comm, coarse, &finer);
  const mesh::SizeField wanted = mesh::sizes_by(second.mesh, second.error, 1, reach);
  const scene::Mesh& own = scene.mesh.automatic() ? coarse.mesh : scene.mesh;
  const auto count = static_cast<double>(cells(comm, own));
  const int dim = wanted.dim;
  const double even = second.extent * std::pow(count, -1.0 / dim); // the size of as many elements in a cube
  scene::Mesh graded = coarse.mesh;
  graded.file = file.parent_path() / ("." + file.filename().string()); // until it is whole
  graded.size.reset();
  mesh::SizeField sizes;
  double factor = std::pow(mesh::count_of(wanted) / count, 1.0 / dim);
  constexpr int corrections = 3;
  for (int i = 0; i < corrections; ++i) {
    sizes = wanted;
    for (double& size : sizes.sizes)
      size *= factor;
    mesh::limit_by_curvature(sizes, std::numbers::pi * second.extent / (around * even));
    mesh::limit_growth(sizes);
    on_root(comm, [&] {
      std::ofstream(graded.file) << mesh::geo_with_sizes(
          sizes, std::filesystem::relative(scene.mesh.file, file.parent_path()), scene.mesh.metres());
    });
    factor *= std::pow(static_cast<double>(cells(comm, graded)) / count, 1.0 / dim);
  }
  const double least = std::ranges::min(sizes.sizes), largest = std::ranges::max(sizes.sizes);
  console.line(fmt::format("element sizes graded by the error of "
                           "{}: from {:.3g} to {:.3g} m, {:.0f} elements",
                           scene.objective ? "J" : "the stress", least, largest,
                           static_cast<double>(cells(comm, graded))));
  on_root(comm, [&] { std::filesystem::rename(graded.file, file); });
}

std::int64_t cells(MPI_Comm comm, const scene::Mesh& mesh) {
  std::int64_t count = 0;
  on_root(comm, [&] {
    const mesh::RawMesh raw = mesh::read_gmsh(mesh);
    count = static_cast<std::int64_t>(raw.cells.size()) / (raw.dim + 1);
  });
  MPI_Bcast(&count, 1, MPI_INT64_T, 0, comm);
  return count;
}

namespace {

/// Number of cells of a mesh with another element size; without mesh.size, `size` scales the sizes that the
/// .geo sets.
std::int64_t cells(MPI_Comm comm, scene::Mesh mesh, double size) {
  (mesh.size ? *mesh.size : mesh.scale) = size;
  return accuracy::cells(comm, mesh);
}

UserError no_answer(const scene::Scene& scene, double coarse, double fine, std::int64_t cells,
                    const char* allowed) {
  const char* kind = scene.mesh.size ? "size" : "scale";
  return UserError(fmt::format("mesh.{0}: {1} has {2} cells both at {0} {3:g} and at {0} {4:g}. The file "
                               "sets its own mesh density (as Transfinite curves do); use {5}",
                               kind, scene.mesh.file.string(), cells, coarse, fine, allowed));
}

} // namespace

void require_sizes_take_effect(MPI_Comm comm, const scene::Scene& scene, const std::vector<double>& sizes) {
  std::vector<double> coarsest = sizes;
  std::ranges::sort(coarsest, std::greater());
  const auto [last, end] = std::ranges::unique(coarsest);
  coarsest.erase(last, end);
  if (coarsest.size() < 2)
    return;
  const std::int64_t coarse = cells(comm, scene.mesh, coarsest[0]),
                     fine = cells(comm, scene.mesh, coarsest[1]);
  if (coarse == fine)
    throw no_answer(scene, coarsest[0], coarsest[1], coarse,
                    "--sizes that change the mesh, or only one size");
}

void require_size_takes_effect(MPI_Comm comm, const scene::Scene& scene) {
  const double size = scene.mesh.size.value_or(scene.mesh.scale);
  const std::int64_t own = cells(comm, scene.mesh, size);
  // The coarser mesh first: it is quicker to make, but where the body's own edges limit it the finer one
  // decides.
  if (own == cells(comm, scene.mesh, 2 * size) && own == cells(comm, scene.mesh, size / 2))
    throw no_answer(scene, 2 * size, size / 2, own, "a .geo whose mesh changes with the size");
}

} // namespace signorini::accuracy
