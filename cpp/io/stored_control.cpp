// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/stored_control.h"
#include "base/collective.h"
#include "control/interpolation.h"
#include "io/checkpoint.h"
#include "io/stored_field.h"
#include "scene/compatibility.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>

namespace signorini::io {
namespace fs = std::filesystem;

namespace {

constexpr double rounding = 1e-9; // of times, relative

/// Whether the folder's checkpoint is of the run whose results are there, or of one that was killed: an
/// earlier run's stays where a later one writes none. Collective.
bool is_of_the_run(CheckpointReader& checkpoint, const fs::path& folder, MPI_Comm comm) {
  std::vector<double> history;
  checkpoint("history", history);
  int same = 1;
  if (rank(comm) == 0) {
    constexpr std::size_t columns = 11, objective = 1;
    std::ifstream in(folder / "run.json", std::ios::binary);
    if (in) {
      const nlohmann::json run = nlohmann::json::parse(in, nullptr, false);
      const double value = run.is_object() && run.contains("objective")
                               ? run["objective"].value("value", std::nan(""))
                               : std::nan("");
      same = history.size() >= columns &&
             std::abs(history[history.size() - columns + objective] - value) <= rounding * std::abs(value);
    }
  }
  MPI_Bcast(&same, 1, MPI_INT, 0, comm);
  return same != 0;
}

/// The time step of the run that wrote a resolved scene. Throws UserError.
double step_of(const std::string& scene, const std::string& key, const fs::path& file) {
  const std::optional<double> step = scene::time_step(scene);
  if (!step || !(*step > 0))
    throw UserError(
        fmt::format("{}: {}: found no time.step, allowed is what a run left", key, file.string()));
  return *step;
}

/// The times between which the stored control is constant, s (rows + 1): of a checkpoint that does not have
/// them, of the steps of the run that wrote the resolved scene. Throws UserError.
std::vector<double> edges_of(CheckpointReader& in, const std::string& scene, int rows, const std::string& key,
                             const fs::path& file) {
  std::vector<double> edges;
  if (in.has("edges")) {
    in("edges", edges);
    if (edges.size() != static_cast<std::size_t>(rows) + 1 || !std::ranges::is_sorted(edges))
      in.fail("\"edges\" is damaged; allowed is a whole checkpoint");
    return edges;
  }
  const double step = step_of(scene, key, file);
  for (int j = 0; j <= rows; ++j)
    edges.push_back(j * step);
  return edges;
}

/// Fails unless a stored control that is constant between `edges` can be one of `controls`.
void require_fitting_time(const CheckpointReader& in, const control::ControlSpace& controls,
                          const std::vector<double>& edges) {
  const double end = controls.grid().end();
  if (edges.size() == 2)
    return;
  if (controls.constant_in_time())
    in.fail(
        "found a control that changes in time, allowed is one that is constant (control.constant_in_time)");
  if (edges.back() < (1 - rounding) * end)
    in.fail(fmt::format(
        "found a control from 0 to {:.6g} s, allowed is one that covers this run, from 0 to {:.6g} s",
        edges.back(), end));
}

/// Of checkpoint.h5 of the same places.
control::Control as_it_was(CheckpointReader& in, const control::ControlSpace& controls,
                           const std::string& scene, const std::string& key, const fs::path& file) {
  std::vector<double> edges;
  return in.control("u", [&](int j, int rows) {
    if (edges.empty()) {
      edges = edges_of(in, scene, rows, key, file);
      require_fitting_time(in, controls, edges);
    }
    const auto after = std::ranges::upper_bound(edges, controls.begin(j) + controls.length(j) / 2);
    return std::clamp(static_cast<int>(after - edges.begin()) - 1, 0, rows - 1);
  });
}

/// The control space of an earlier run, made again from its resolved scene.
struct EarlierRun {
  EarlierRun(MPI_Comm comm, const scene::Scene& scene)
      : mesh(comm, scene.mesh), space(mesh, scene.mesh.degree),
        operators(fem::assemble_operators(space, scene.materials, true)),
        controls(space, operators, forward::TimeGrid(scene.time), *scene.control) {}

  mesh::Mesh mesh;
  fem::Space space;
  fem::Operators operators;
  control::ControlSpace controls;
};

/// Dimension of the set on which a control acts.
int dimension(const control::ControlSpace& controls) {
  const mesh::Mesh& mesh = controls.space().mesh();
  return controls.on() ? mesh.group_dimension(*controls.on(), "control.on") : mesh.dim();
}

/// Of checkpoint.h5 of a run on another mesh, which is made again from its scene.
control::Control interpolated(const CheckpointReader& known, const control::ControlSpace& controls,
                              const std::string& text, const fs::path& file, const std::string& key) {
  std::optional<EarlierRun> run;
  try {
    run.emplace(controls.space().comm(), scene::parse(text, file.parent_path() / "scene.toml"));
  } catch (const UserError& error) {
    known.fail(fmt::format("found a control on another mesh, which cannot be made again: {}", error.what()));
  }
  CheckpointReader in(run->controls, file, key);
  if (!in.matches_places())
    known.fail(
        "found a control on another mesh, whose file has changed since; allowed is the file as it was, or "
        "the mesh of that run");
  const int here = dimension(controls), there = dimension(run->controls);
  if (run->mesh.dim() != controls.space().dim() || there != here)
    known.fail(fmt::format("found a control on a set of {} dimensions, allowed are {} as in this scene",
                           there, here));
  const auto row = [&](int j, int rows) {
    if (j == 1)
      require_fitting_time(in, controls, edges_of(in, text, rows, key, file));
    return std::min(j, rows) - 1;
  };
  const control::Control u = in.control("u", row);
  return control::Interpolation(run->controls, controls)(u);
}

/// Of control.h5, where the value of a step stands at its end.
control::Control as_stored(const control::ControlSpace& controls, const fs::path& folder,
                           const std::string& key) {
  const MPI_Comm comm = controls.space().comm();
  const fs::path echo = folder / "scene.toml";
  std::string scene;
  on_root(comm, [&] {
    std::error_code none;
    if (!fs::is_regular_file(folder / "control.h5", none) || !fs::is_regular_file(echo, none))
      throw UserError(
          fmt::format("{}: {} has neither a checkpoint.h5 nor a control.h5 of its run, allowed is the "
                      "folder of an optimize that left one",
                      key, folder.string()));
    if (controls.cellwise())
      throw UserError(
          fmt::format("{}: {} has no checkpoint.h5 of its run, from which controls with values in cells are "
                      "read, allowed is the folder of an optimize that left one",
                      key, folder.string()));
    scene = scene::read_file(echo);
  });
  const double step = step_of(broadcast(comm, scene), key, echo), end = controls.grid().end();
  StoredField stored(controls.space(), folder / "control.h5", "control", key, end, false);
  control::Control u = controls.zero();
  const petsc::Vector field = controls.field();
  for (int j = 1; j <= u.count(); ++j) {
    stored.at(std::min(controls.begin(j) + controls.length(j) / 2 + step / 2, end), field);
    controls.restrict(field, u.at(j));
  }
  return u;
}

} // namespace

control::Control stored_control(const control::ControlSpace& controls, const fs::path& folder,
                                const std::string& key) {
  const MPI_Comm comm = controls.space().comm();
  const fs::path file = folder / "checkpoint.h5";
  int there = 0;
  if (rank(comm) == 0) {
    std::error_code none;
    there = fs::is_regular_file(file, none);
  }
  MPI_Bcast(&there, 1, MPI_INT, 0, comm);
  if (there != 0) {
    CheckpointReader in(controls, file, key);
    if (is_of_the_run(in, folder, comm)) {
      std::string scene;
      in("scene", scene);
      if (!in.matches_places())
        return interpolated(in, controls, scene, file, key);
      return as_it_was(in, controls, scene, key, file);
    }
  }
  return as_stored(controls, folder, key);
}

} // namespace signorini::io
