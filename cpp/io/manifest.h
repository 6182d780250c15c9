#pragma once
#include "base/timers.h"
#include "control/objective.h"
#include "forward/invariants.h"
#include "scene/scene.h"
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace signorini::io {

/// What run.json tells of a run.
struct Manifest {
  std::string verb;
  std::string stop_reason;
  int ranks = 1;
  long unknowns = 0, free_unknowns = 0, cells = 0;
  int candidates = 0;
  int steps_done = 0;
  std::string solver;     ///< of the steps, and why
  double peak_memory = 0; ///< bytes, summed over the ranks
  std::optional<control::Value> objective;
  std::vector<forward::Invariants::Defect> invariants; ///< of the motion stored, none if none was watched
  std::optional<int> iterations, forward_sweeps, adjoint_sweeps;
};

/// Of this program and the libraries whose versions matter.
nlohmann::ordered_json versions();

/// run.json.
std::string to_json(const Manifest& manifest, const scene::Scene& scene, const Timers& timers);

/// The scene's effects by name, on or off.
std::vector<std::pair<std::string, bool>> effects(const scene::Scene& scene);

} // namespace signorini::io
