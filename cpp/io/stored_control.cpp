// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/stored_control.h"
#include "base/collective.h"
#include "control/interpolation.h"
#include "io/checkpoint.h"
#include "io/csv_tables.h"
#include "io/field_reader.h"
#include "scene/compatibility.h"
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace signorini::io {
namespace fs = std::filesystem;

namespace {

constexpr double rounding = 1e-9; // of times, relative

/// Value of J without the misfit and prior of a fit, from the last row of a checkpoint's history; nan if
/// there is no row. Collective.
double last_objective(CheckpointReader& checkpoint) {
  std::string columns;
  checkpoint("columns", columns);
  History history{.columns = History::split(columns), .numbers = {}};
  checkpoint("history", history.numbers);
  if (history.rows() == 0)
    return std::nan("");
  if (std::ranges::find(history.columns, "misfit") == history.columns.end())
    return history.last("objective");
  double sum = 0;
  for (const char* part : {"tracking", "terminal", "control_cost"})
    sum += history.last(part);
  return sum;
}

/// Value of J in a run.json; nan if run.json has none.
double objective_in(std::istream& run_json) {
  const nlohmann::json run = nlohmann::json::parse(run_json, nullptr, false);
  const nlohmann::json::json_pointer value("/objective/value");
  return run.contains(value) && run.at(value).is_number() ? run.at(value).get<double>() : std::nan("");
}

/// Whether the checkpoint and the results in a folder belong to the same run: their values of J agree, or
/// there are no results. An earlier run's checkpoint stays if a later run writes none. Collective.
bool is_of_the_run(CheckpointReader& checkpoint, const fs::path& folder, MPI_Comm comm) {
  const double last = last_objective(checkpoint);
  int same = 1;
  if (rank(comm) == 0) {
    std::ifstream in(folder / "run.json", std::ios::binary);
    if (in) {
      const double value = objective_in(in);
      same = std::abs(last - value) <= rounding * std::abs(value);
    }
  }
  MPI_Bcast(&same, 1, MPI_INT, 0, comm);
  return same != 0;
}

std::string where(const std::string& on) { return on.empty() ? "the body" : fmt::format("\"{}\"", on); }

/// Reason why a control of an earlier run cannot act in this scene, by scale, group or components; empty if
/// it can.
std::string otherness(const scene::ControlKeys& there, const control::ControlSpace& controls,
                      const scene::Control& here) {
  if (std::abs(there.scale - here.scale) > rounding * here.scale)
    return fmt::format("found a control with control.scale = {:.10g}, but this scene has {:.10g}; use the "
                       "same value",
                       there.scale, here.scale);
  if (there.on != here.on.value_or(""))
    return fmt::format("found a control on {}, but this scene's control acts on {}; use the same group "
                       "(control.on)",
                       where(there.on), where(here.on.value_or("")));
  const std::vector<scene::Component> all = scene::components(controls.space().dim());
  std::vector<std::string> acting;
  for (const int component : controls.components())
    acting.push_back(scene::name(all[static_cast<std::size_t>(component)]));
  for (const std::string& component : there.components)
    if (std::ranges::find(acting, component) == acting.end())
      return fmt::format("found a control in {}, but this scene's control acts in {}; include its components "
                         "(control.components)",
                         fmt::join(there.components, ", "), fmt::join(acting, ", "));
  return {};
}

/// Ends of the intervals on which a control of an earlier run is constant, s, according to that run's scene.
/// Empty for steps of varying length, which the scene does not determine.
std::vector<double> edges_of(const scene::ControlKeys& keys) {
  if (keys.constant_in_time)
    return {0, keys.end};
  const double length = keys.step > 0 ? keys.step : keys.time_step;
  std::vector<double> edges;
  if (length > 0)
    for (long j = 0; j <= std::lround(keys.end / length); ++j)
      edges.push_back(static_cast<double>(j) * length);
  return edges;
}

/// Ends of the intervals on which a checkpoint's control with `rows` rows is constant, s. Throws UserError if
/// their number does not match.
std::vector<double> edges_of(CheckpointReader& in, const scene::ControlKeys& keys, int rows) {
  std::vector<double> edges;
  if (in.has("edges")) // not of a joint search
    in("edges", edges);
  else
    edges = edges_of(keys);
  if (edges.size() != static_cast<std::size_t>(rows) + 1 || !std::ranges::is_sorted(edges))
    in.fail("\"edges\" is damaged or missing; use an undamaged checkpoint");
  return edges;
}

/// Number, from 0, of the interval between two successive `edges` (s) that contains the time t (s).
int interval_at(const std::vector<double>& edges, double t) {
  const auto after = std::ranges::upper_bound(edges, t);
  return std::clamp(static_cast<int>(after - edges.begin()) - 1, 0, static_cast<int>(edges.size()) - 2);
}

/// Middle of interval j of this run's controls, s.
double middle(const control::ControlSpace& controls, int j) {
  return controls.begin(j) + controls.length(j) / 2;
}

/// Reason why a stored control that is constant between `edges` (s) does not fit the times of `controls`;
/// empty if it does.
std::string untimely(const control::ControlSpace& controls, const std::vector<double>& edges) {
  const double end = controls.grid().end();
  if (edges.size() == 2)
    return {};
  if (controls.constant_in_time())
    return "found a control that changes in time; use one that is constant (control.constant_in_time)";
  if (edges.back() < (1 - rounding) * end)
    return fmt::format("found a control from 0 to {:.6g} s; use one that covers this run, from 0 to {:.6g} s",
                       edges.back(), end);
  return {};
}

/// Name of the final control in a checkpoint: "u/control" in a search that has unknowns too, else "u".
std::string name_in(const CheckpointReader& in) { return in.has("u/control") ? "u/control" : "u"; }

/// Reads the control of checkpoint.h5 on the same nodes or cells.
control::Control as_it_was(CheckpointReader& in, const control::ControlSpace& controls,
                           const scene::ControlKeys& keys) {
  std::vector<double> edges;
  return in.control(name_in(in), [&](int j, int rows) {
    if (edges.empty()) {
      edges = edges_of(in, keys, rows);
      if (const std::string problem = untimely(controls, edges); !problem.empty())
        in.fail(problem);
    }
    return interval_at(edges, middle(controls, j));
  });
}

/// Control space of an earlier run, rebuilt from that run's resolved scene.
struct EarlierRun {
  EarlierRun(MPI_Comm comm, const scene::Scene& scene)
      : mesh(comm, scene.mesh), space(mesh, scene.mesh.degree),
        operators(fem::assemble_operators(space, scene.materials, true)),
        controls(space, operators, step::TimeGrid(scene.time), *scene.control) {}

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

/// Throws UserError if the sets on which the control acts in two meshes are farther apart than the chords of
/// a curved boundary explain: 2 % of `diameter` (m).
void require_same_place(const CheckpointReader& in, const control::Interpolation& there_to_here,
                        const control::Interpolation& here_to_there, double diameter) {
  constexpr double chords = 0.02; // of the body: those of elements of half the radius
  const double distance = std::max(there_to_here.farthest(), here_to_there.farthest());
  if (distance > chords * diameter)
    in.fail(fmt::format("found a control up to {:.4g} m away from this scene's control (body diameter: "
                        "{:.4g} m); use a control of the same body and place",
                        distance, diameter));
}

/// Interpolates the control of checkpoint.h5 from the mesh of an earlier run, rebuilt from that run's scene.
control::Control interpolated(const CheckpointReader& known, const control::ControlSpace& controls,
                              const scene::ControlKeys& keys, const std::string& text, const fs::path& file,
                              const std::string& key) {
  std::optional<EarlierRun> run;
  try {
    run.emplace(controls.space().comm(), scene::parse(text, file.parent_path() / "scene.toml"));
  } catch (const UserError& error) {
    known.fail(fmt::format("found a control on another mesh, which cannot be regenerated: {}", error.what()));
  }
  CheckpointReader in(run->controls, file, key);
  if (!in.matches_places())
    known.fail("found a control on another mesh, whose file has changed since; restore the file, or use the "
               "mesh of that run");
  const int here = dimension(controls), there = dimension(run->controls);
  if (run->mesh.dim() != controls.space().dim() || there != here)
    known.fail(fmt::format(
        "found a control on a group of dimension {}; expected dimension {} as in this scene", there, here));
  const control::Interpolation to_here(run->controls, controls);
  require_same_place(known, to_here, {controls, run->controls}, controls.space().mesh().diameter());
  const auto row = [&](int j, int rows) {
    if (j == 1)
      if (const std::string problem = untimely(controls, edges_of(in, keys, rows)); !problem.empty())
        in.fail(problem);
    return std::min(j, rows) - 1;
  };
  return to_here(in.control(name_in(in), row));
}

/// Reads the control from control.h5, which stores the value of a step at the end of the step. `why`: reason
/// why checkpoint.h5 is not read, for messages.
control::Control as_stored(const control::ControlSpace& controls, const scene::Control& here,
                           const fs::path& folder, const std::string& key, const std::string& why) {
  const MPI_Comm comm = controls.space().comm();
  const fs::path echo = folder / "scene.toml", file = fields_file(folder, "control");
  const auto fail = [&](const std::string& problem) {
    throw UserError(fmt::format("{}: {}: {}", key, file.string(), problem));
  };
  std::string scene;
  on_root(comm, [&] {
    std::error_code none;
    if (!fs::is_regular_file(file, none) || !fs::is_regular_file(echo, none))
      throw UserError(fmt::format("{}: {} has no control.h5 that its run wrote, and {}; use the folder of an "
                                  "optimize run that wrote control.h5",
                                  key, folder.string(), why));
    if (controls.cellwise())
      throw UserError(fmt::format("{}: {} has no checkpoint.h5 of its run, which a control with values in "
                                  "cells needs. Use the folder of an optimize run that wrote checkpoint.h5",
                                  key, folder.string()));
    scene = scene::read_file(echo);
  });
  const std::optional<scene::ControlKeys> keys = scene::control_keys(broadcast(comm, scene));
  if (!keys || !(keys->time_step > 0))
    throw UserError(fmt::format("{}: {}: found no time.step; use the folder of a run", key, echo.string()));
  const std::vector<double> edges = edges_of(*keys);
  for (const std::string& problem : {otherness(*keys, controls, here), untimely(controls, edges)})
    if (!problem.empty())
      fail(problem);
  StoredField stored(controls.space(), file, "control", key, controls.grid().end(), false);
  const double hair = rounding * keys->end;
  control::Control u = controls.zero();
  const petsc::Vector field = controls.field();
  for (int j = 1; j <= u.count(); ++j) {
    const auto i = static_cast<std::size_t>(interval_at(edges, middle(controls, j)));
    // The first step stored that is within the interval: others have the mean of several.
    const auto step = std::ranges::lower_bound(stored.times(), edges[i] + keys->time_step - hair);
    if (step == stored.times().end() || *step > edges[i + 1] + hair)
      fail(fmt::format("found no step stored between {:.6g} and {:.6g} s, and {}; use a run with a "
                       "checkpoint (optimizer.checkpoint), or with output.every = 1",
                       edges[i], edges[i + 1], why));
    stored.at(*step, field);
    controls.restrict(field, u.at(j));
  }
  return u;
}

} // namespace

control::Control stored_control(const control::ControlSpace& controls, const scene::Control& scene,
                                const fs::path& folder, const std::string& key) {
  const MPI_Comm comm = controls.space().comm();
  const fs::path file = folder / "checkpoint.h5";
  int there = 0;
  if (rank(comm) == 0) {
    std::error_code none;
    there = fs::is_regular_file(file, none);
  }
  MPI_Bcast(&there, 1, MPI_INT, 0, comm);
  if (there == 0)
    return as_stored(controls, scene, folder, key, "there is no checkpoint.h5");
  CheckpointReader in(controls, file, key);
  if (!in.has(name_in(in)))
    return as_stored(controls, scene, folder, key, "checkpoint.h5 belongs to a search without a control");
  if (!is_of_the_run(in, folder, comm))
    return as_stored(controls, scene, folder, key, "checkpoint.h5 belongs to another run");
  std::string text;
  in("scene", text);
  const std::optional<scene::ControlKeys> keys = scene::control_keys(text);
  if (!keys)
    in.fail("\"scene\" is damaged; use an undamaged checkpoint");
  if (const std::string problem = otherness(*keys, controls, scene); !problem.empty())
    in.fail(problem);
  const bool same_components = keys->components.size() == controls.components().size();
  if (same_components && in.matches_places())
    return as_it_was(in, controls, *keys);
  return interpolated(in, controls, *keys, text, file, key);
}

} // namespace signorini::io
