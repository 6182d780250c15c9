// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/timers.h"
#include "control/objective.h"
#include "diagnostics/balance.h"
#include "diagnostics/impact_summary.h"
#include "diagnostics/plausibility.h"
#include "diagnostics/warnings.h"
#include "fem/deformation.h"
#include "io/fit_tables.h"
#include "scene/scene.h"
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace signorini::io {

/// A candidate in weak contact in a step: closed without force.
struct WeakContact {
  int step;
  double time; ///< s
  int candidate;
  std::vector<double> x; ///< point of its node in the undeformed body (dim), m
};

/// A kink at which a search ended: optimize::Certificate and the weak contact that causes it.
struct Kink {
  double length, radius;
  int gradients;
  std::vector<WeakContact> weak;
};

/// A search on a coarse mesh before the search on the scene's mesh.
struct CoarseLevel {
  double size = 0, step = 0; ///< m, s
  int steps = 0;
  long free_unknowns = 0;
  int iterations = 0, forward_sweeps = 0, adjoint_sweeps = 0;
  double seconds = 0; ///< meshing and factorisation included
  double objective = 0;
  std::string stop_reason{};
};

/// Required and estimated errors of a quantity, relative to its modulus.
struct Accuracy {
  std::string quantity;
  double asked = 0, space = 0, time = 0;
  double search = 0;     ///< error left by the optimizer
  bool met = false;      ///< attained, with half the steps too and without a warning
  std::string warning{}; ///< why a small estimate is not verified, in words
  [[nodiscard]] double estimated() const { return space + time + search; }
};

/// Steps of varying length of a motion.
struct Lengths {
  double shortest = 0, longest = 0; ///< s
  int rejected = 0;                 ///< steps that were repeated
  int factorisations = 0;           ///< factorisations of step operators, repeated ones included
  double seconds = 0;               ///< time of these factorisations
};

/// The contents of run.json.
struct Manifest {
  std::string verb;
  std::string stop_reason;
  int ranks = 1;
  long unknowns = 0, free_unknowns = 0, cells = 0;
  int candidates = 0;
  int steps_asked = 0;              ///< steps of the whole motion
  std::optional<Lengths> lengths{}; ///< present if steps vary in length
  int steps_done = 0;
  int stored = 0;           ///< times at which fields and contact were stored
  double wave_time = 0;     ///< step::Stepper::wave_time(), s
  std::string control_unit; ///< unit of control.scale, empty without a control
  std::string solver;       ///< solver of the steps, and the reason of its choice
  double peak_memory = 0;   ///< bytes, summed over the ranks
  int dim = 2;
  diagnostics::BodyFigures body;
  std::optional<control::ObjectiveValue> objective;
  std::optional<diagnostics::EnergyAccount> energy; ///< energy of the stored motion; absent if not computed
  std::optional<diagnostics::Impact> impact;        ///< absent if not computed, or in a scene without contact
  std::optional<diagnostics::LargestStress::Peak> von_mises; ///< absent if no stress is stored
  std::vector<diagnostics::Invariants::Defect> invariants;   ///< defects found; empty if not monitored
  std::vector<Warning> warnings;                             ///< warnings on the stored motion
  std::optional<int> iterations, forward_sweeps, adjoint_sweeps;
  std::vector<CoarseLevel> coarse_levels; ///< the coarsest first
  std::optional<Kink> kink;
  std::optional<Accuracy> accuracy{};
  std::optional<Fit> fit;
  std::vector<std::string> files; ///< files of the run
};

/// Whether the largest stress is that of a wave at the onset of contact, whose front depends on mesh and
/// steps.
[[nodiscard]] bool stress_at_onset(const Manifest& m);

/// JSON document as lines of text; bytes that are not UTF-8, as in some file names, are replaced.
std::string lines(const nlohmann::ordered_json& json);

/// Versions of this program and of its main libraries.
nlohmann::ordered_json versions();
/// Versions of this program and of its main libraries on one line.
std::string version_line();

/// The text of run.json.
std::string to_json(const Manifest& manifest, const scene::Scene& scene, const Timers& timers);

/// The scene's effects by name, on or off.
std::vector<std::pair<std::string, bool>> effects(const scene::Scene& scene);

} // namespace signorini::io
