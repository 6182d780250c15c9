// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/reader.h"
#include <string>
#include <vector>

/// Rules that involve several keys or tables of a scene. Each function throws UserError if a rule is broken;
/// `scene` is the part of the scene read so far.
namespace signorini::scene {

void require_rules(Reader& in, const Mesh& mesh, const Scene& scene);
/// Checks the rules of [time] and sets the number of steps.
void require_rules(Reader& in, Time& time, const Scene& scene);
void require_rules(Reader& in, const Branch& branch, const Scene& scene);
void require_rules(Reader& in, const Material& material, const Scene& scene);
void require_rules(Reader& in, const Foundation& foundation, const Scene& scene);
void require_rules(Reader& in, const HalfSpace& obstacle, const Scene& scene);
void require_rules(Reader& in, const Ball& obstacle, const Scene& scene);
void require_rules(Reader& in, const Cylinder& obstacle, const Scene& scene);
void require_rules(Reader& in, const Contact& contact, const Scene& scene);
void require_rules(Reader& in, const Load& load, const Scene& scene);
void require_rules(Reader& in, const Initial& initial, const Scene& scene);
void require_rules(Reader& in, Control& control, const Scene& scene);
void require_rules(Reader& in, const Objective& objective, const Scene& scene);
void require_rules(Reader& in, const Optimizer& optimizer, const Scene& scene);
void require_rules(Reader& in, const Trajectory& trajectory, const Scene& scene);
void require_rules(Reader& in, const Exact& exact, const Scene& scene);
void require_rules(Reader& in, const Solver& solver, const Scene& scene);
/// Checks the rules of [[scenario]] and sets the name if the table does not give it.
void require_rules(Reader& in, Scenario& scenario, const Scene& scene);
/// Checks the rules of [[unknown]] and sets name, start and scale if the table does not give them.
void require_rules(Reader& in, Unknown& unknown, const Scene& scene);
/// Checks the rules of [[measurement]] and sets the name if the table does not give it.
void require_rules(Reader& in, Measurement& measurement, const Scene& scene);
void require_rules(Reader& in, Probe& probe, const Scene& scene);
void require_rules(Reader& in, const Output& output, const Scene& scene);
/// Checks the rules between tables and sets defaults: start and tolerance of a search, the longest time step.
void require_rules(Reader& in, Scene& read, const Scene& scene);
/// Checks the rules of mesh.model for one table.
void require_model(const Reader& in, const Cylinder& obstacle, const Scene& scene);
void require_model(const Reader& in, const Material& material, const Scene& scene);
void require_model(const Reader& in, const Unknown& unknown, const Scene& scene);
void require_model(const Reader& in, const Measurement& measurement, const Scene& scene);
/// Reads the key `name` of a table in an array of tables; `otherwise`: name if the key is absent. The name
/// must differ from `others`, the names of the preceding tables, and have no commas or quotes. `table`: key
/// of the array, for messages.
std::string unique_name(Reader& in, const std::string& otherwise, const std::vector<std::string>& others,
                        const char* table);
/// Reads the key `name` for the last element of `all`. The elements before it have names already.
template <class T>
std::string unique_name(Reader& in, const std::string& otherwise, const std::vector<T>& all,
                        const char* table) {
  std::vector<std::string> others;
  for (std::size_t i = 0; i + 1 < all.size(); ++i)
    others.push_back(all[i].name);
  return unique_name(in, otherwise, others, table);
}
/// Describes the fractions of a material's Prony series whose sum is too large, as the end of a message;
/// empty if none is.
std::string excess_of_fractions(const Material& material);
/// Throws UserError, naming the key `obstacle`, unless the scene has an obstacle of that name.
void require_obstacle(const Reader& in, const std::string& obstacle, const Scene& scene);
/// Throws UserError unless the scene has an obstacle with mass named `obstacle`.
void require_mass(const Reader& in, const std::string& obstacle, const Scene& scene);
/// Throws UserError, naming `key`, if an obstacle with mass has the mass 0: then only its displacement is
/// determined, and its velocity alternates from step to step.
void require_inert(const Reader& in, const std::string& obstacle, const Scene& scene, const char* key);
/// Checks the rules of scenes with scenarios.
void require_scenario_rules(Reader& in, const Scene& scene);
/// Checks the rules of scenes with unknowns or measurements, and sets the search method for the unknowns.
void require_fit_rules(Reader& in, Scene& scene);
/// Sets the time that a scene with time.end = "auto" has at most. Throws UserError if the scene needs an end.
void set_latest_end(Reader& in, Scene& scene);
/// Reads the name of the scene's last obstacle from the obstacle's table; "obstacle 1", "obstacle 2", … if
/// the table gives none.
std::string obstacle_name(Reader& in, const Scene& scene);
/// Name of a pair of surfaces, "on/against". Throws UserError if another contact has it.
std::string pair_name(const Reader& in, const Contact& contact, const Scene& scene);
/// Accepts tables of all other types, which have no rules.
template <class T>
void require_rules(Reader&, const T&, const Scene&) {}

} // namespace signorini::scene
