#pragma once
#include "base/timers.h"
#include "control/objective.h"
#include "forward/invariants.h"
#include "forward/plausibility.h"
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
  std::vector<double> x; ///< of its node in the undeformed body (dim), m
};

/// Where a search ended at a kink: optimize::Certificate, and the weak contact that makes it.
struct Kink {
  double length, radius;
  int gradients;
  std::vector<WeakContact> weak;
};

/// What run.json tells of a run.
struct Manifest {
  std::string verb;
  std::string stop_reason;
  int ranks = 1;
  long unknowns = 0, free_unknowns = 0, cells = 0;
  int candidates = 0;
  int steps_done = 0;
  std::string control_unit; ///< of control.scale, empty without a control
  std::string solver;     ///< of the steps, and why
  double peak_memory = 0; ///< bytes, summed over the ranks
  std::optional<control::Value> objective;
  std::vector<forward::Invariants::Defect> invariants; ///< of the motion stored, none if none was watched
  std::vector<forward::Warning> warnings;              ///< of the motion stored
  std::optional<int> iterations, forward_sweeps, adjoint_sweeps;
  std::optional<Kink> kink;
  std::vector<std::string> files; ///< that the run leaves
};

/// Of this program and the libraries whose versions matter.
nlohmann::ordered_json versions();

/// run.json.
std::string to_json(const Manifest& manifest, const scene::Scene& scene, const Timers& timers);

/// The scene's effects by name, on or off.
std::vector<std::pair<std::string, bool>> effects(const scene::Scene& scene);

} // namespace signorini::io
