// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/timers.h"
#include "control/objective.h"
#include "diagnostics/balance.h"
#include "diagnostics/body_figures.h"
#include "diagnostics/impact_summary.h"
#include "diagnostics/largest_stress.h"
#include "diagnostics/probe_peaks.h"
#include "fem/deformation.h"
#include "io/fit_tables.h"
#include "scene/scene.h"
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace signorini::io {

/// A scenario at the control that a search found: a row of scenarios.csv.
struct ScenarioResult {
  std::string name;
  double weight = 0, share = 0; ///< w_s and q_s of control::ScenarioProblem
  control::ObjectiveValue value{};
};

/// Text of scenarios.csv: one row for each scenario.
std::string scenarios_table(const std::vector<ScenarioResult>& scenarios);

/// A candidate that is weakly active in a step at a kink: in this step, or at its predictor, it is active at
/// some points of optimize::Certificate and open at the others.
struct WeakContact {
  int motion; ///< 0: of the scene itself; else number of the scenario among those that change it
  int step;
  double time; ///< end of the step, s
  int candidate;
  std::vector<double> x; ///< point of the candidate's node in the undeformed body (dim), m
};

/// A kink of J at which a search ended: the data of optimize::Certificate and the weakly active candidates
/// that cause the kink.
struct Kink {
  double length, radius; ///< length of the combination of gradients; radius of the ball of their points
  int gradients;         ///< number of gradients in the combination
  std::vector<WeakContact> weak;
};

/// Record of a search on a coarse mesh that preceded the search on the scene's mesh.
struct CoarseLevel {
  double size = 0, step = 0; ///< element size, m; length of a time step, s
  int steps = 0;             ///< number of time steps
  long free_unknowns = 0;
  int iterations = 0, forward_sweeps = 0, adjoint_sweeps = 0;
  double seconds = 0;   ///< wall-clock time, with meshing and factorisation
  double objective = 0; ///< J at the end of the search
  std::string stop_reason{};
};

/// Required and estimated errors of a quantity, relative to the quantity's modulus.
struct Accuracy {
  std::string quantity;
  double asked = 0, space = 0, time = 0; ///< required error; estimated errors of mesh and of time steps
  double search = 0;                     ///< estimated error of the optimizer
  bool met = false; ///< whether `warning` is empty and estimated() is at most `asked` (optimize: half of it)
  std::string warning{}; ///< why a sufficiently small estimate is not verified; empty if it is verified
  /// Estimated total error: the sum of its parts.
  [[nodiscard]] double estimated() const { return space + time + search; }
};

/// Statistics of the time steps of a motion whose steps vary in length.
struct StepStatistics {
  double shortest = 0, longest = 0; ///< shortest and longest step, s
  int rejected = 0;                 ///< number of steps that were rejected and repeated
  int factorisations = 0;           ///< number of factorisations, including repeated ones for a length
  double seconds = 0;               ///< wall-clock time of these factorisations
};

/// The contents of run.json.
struct Manifest {
  std::string verb;
  std::string stop_reason;
  int ranks = 1;
  long unknowns = 0, free_unknowns = 0, cells = 0;
  int candidates = 0;
  int steps_asked = 0;                     ///< number of steps of the whole motion
  std::optional<StepStatistics> lengths{}; ///< present if steps vary in length
  int steps_done = 0;                      ///< number of steps computed
  int stored = 0;                          ///< number of times at which fields and contact were stored
  double wave_time = 0;                    ///< least time in which a pressure wave crosses an element, s
  std::string control_unit;                ///< unit of control.scale, empty without a control
  std::string solver;                      ///< linear solver of the steps, and the reason for its choice
  double peak_memory = 0;                  ///< bytes, summed over the ranks
  int dim = 2;
  diagnostics::BodyFigures body;
  std::optional<control::ObjectiveValue> objective;
  std::vector<ScenarioResult> scenarios{};
  std::optional<diagnostics::EnergyAccount> energy; ///< energy of the stored motion; absent if not computed
  std::optional<diagnostics::Impact> impact;        ///< absent if not computed, or in a scene without contact
  std::optional<diagnostics::LargestStress::Peak> von_mises; ///< absent if no stress is stored
  std::vector<diagnostics::ProbePeak> probes;                ///< peaks of accelerations and filtered forces
  std::vector<diagnostics::Invariants::Defect> invariants;   ///< largest defect of each law, if monitored
  std::vector<Warning> warnings;                             ///< warnings on the stored motion
  std::optional<int> iterations, forward_sweeps, adjoint_sweeps;
  std::vector<CoarseLevel> coarse_levels; ///< searches on coarse meshes, the coarsest first
  std::optional<Kink> kink;
  std::optional<Accuracy> accuracy{};
  std::optional<Fit> fit;
  std::vector<std::string> files; ///< names of the files of the run
};

/// Whether the largest stress occurs right after contact begins, within the time in which a wave crosses the
/// body. The wave front, and thus this stress, depends on mesh and time steps.
[[nodiscard]] bool stress_at_onset(const Manifest& m);

/// Writes a JSON document as indented text. Bytes that are not UTF-8, as in some file names, are replaced.
std::string lines(const nlohmann::ordered_json& json);

/// Versions of this program and of its main libraries, by name.
nlohmann::ordered_json versions();
/// Versions of this program and of its main libraries on one line.
std::string version_line();

/// Text of run.json.
std::string to_json(const Manifest& manifest, const scene::Scene& scene, const Timers& timers);

/// Names of all effects of the model, such as viscosity or gravity, and for each whether the scene uses it.
std::vector<std::pair<std::string, bool>> effects(const scene::Scene& scene);

} // namespace signorini::io
