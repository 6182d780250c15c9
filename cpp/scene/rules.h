// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/reader.h"
#include <string>
#include <vector>

/// Rules for tables that involve several keys or tables. Each function throws UserError; `scene` is the part
/// read so far.
namespace signorini::scene {

void require_rules(Reader& in, const Mesh& mesh, const Scene& scene);
/// Checks the steps and sets their number.
void require_rules(Reader& in, Time& time, const Scene& scene);
void require_rules(Reader& in, const Material& material, const Scene& scene);
void require_rules(Reader& in, const Cylinder& obstacle, const Scene& scene);
void require_rules(Reader& in, const Contact& contact, const Scene& scene);
void require_rules(Reader& in, Control& control, const Scene& scene);
void require_rules(Reader& in, const Objective& objective, const Scene& scene);
void require_rules(Reader& in, const Optimizer& optimizer, const Scene& scene);
void require_rules(Reader& in, const Trajectory& trajectory, const Scene& scene);
void require_rules(Reader& in, const Exact& exact, const Scene& scene);
/// Sets name, start and scale that are not given.
void require_rules(Reader& in, Unknown& unknown, const Scene& scene);
/// Sets a name that is not given.
void require_rules(Reader& in, Measurement& measurement, const Scene& scene);
void require_rules(Reader& in, Probe& probe, const Scene& scene);
void require_rules(Reader& in, const Output& output, const Scene& scene);
/// Checks rules between tables and sets defaults: start and tolerance of a search, the longest step.
void require_rules(Reader& in, Scene& read, const Scene& scene);
/// Reads the name of one of several things, for columns and rows of tables; `otherwise` where its table gives
/// none. `others`: names of those before it; `table`: key of their tables.
std::string unique_name(Reader& in, const std::string& otherwise, const std::vector<std::string>& others,
                        const char* table);
/// Reads the name of the last of `all`.
template <class T>
std::string unique_name(Reader& in, const std::string& otherwise, const std::vector<T>& all,
                        const char* table) {
  std::vector<std::string> others;
  for (std::size_t i = 0; i + 1 < all.size(); ++i)
    others.push_back(all[i].name);
  return unique_name(in, otherwise, others, table);
}
/// Throws UserError unless the scene has an obstacle of that name, under the key `obstacle`.
void require_obstacle(const Reader& in, const std::string& obstacle, const Scene& scene);
/// Checks the rest of a scene against its unknowns; sets the method that seeks them.
void require_fit_rules(Reader& in, Scene& scene);
/// Reads the name of the obstacle whose table is read, the last of the scene's so far; a default one where
/// none is given.
std::string obstacle_name(Reader& in, const Scene& scene);
/// Accepts any other table.
template <class T>
void require_rules(Reader&, const T&, const Scene&) {}

} // namespace signorini::scene
