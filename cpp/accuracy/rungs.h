// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <cmath>
#include <map>
#include <string>
#include <vector>

/// Accuracy against cost: a ladder of runs of one scene, with errors and observed orders of convergence.
namespace signorini::accuracy {

/// Settings of one run of a ladder.
struct Rung {
  double size = 1; ///< element size, m; without mesh.size, a factor on the sizes that the .geo sets
  int steps = 0;   ///< number of steps of equal length; 0: steps of varying length
  int degree = 1;  ///< degree of the displacement
  scene::ContactScheme scheme = scene::ContactScheme::contact_implicit;
  double tolerance = 0; ///< time.tolerance of steps of varying length, else 0
  bool graded = false;  ///< whether the mesh is Mesh::graded, scaled to about as many elements as at `size`

  /// Whether steps vary in length.
  [[nodiscard]] bool has_varying_steps() const { return tolerance > 0; }
  /// Dimensionless width of the steps, to whose square the error in time is proportional. For steps of equal
  /// length: length of a step over the duration of the motion; for steps of varying length: √tolerance.
  [[nodiscard]] double step_width() const { return has_varying_steps() ? std::sqrt(tolerance) : 1.0 / steps; }
  /// This rung with a step_width() that is `factor` times as large; numbers of steps are rounded up.
  [[nodiscard]] Rung with_steps(double factor) const;

  friend auto operator<=>(const Rung&, const Rung&) = default;
};

/// Settings from which a ladder is made; an empty list stands for the default.
struct Choice {
  std::vector<double> sizes{}, steps{}; ///< element sizes, m; lengths of steps, s
  std::vector<int> degrees{};
  std::vector<std::string> schemes{};  ///< names of scene::ContactScheme except mixed
  std::vector<double> tolerances = {}; ///< values of time.tolerance for steps of varying length
  bool graded = false;                 ///< whether to run each rung also with a graded mesh
};

/// Values of time.scheme and contact.mass for a contact scheme of a scene, as on_rung() sets them; mass is
/// "mixed" if it differs between contacts.
struct SchemeAndMass {
  std::string scheme, mass;
};
SchemeAndMass scheme_and_mass(const scene::Scene& scene, scene::ContactScheme scheme);

/// Makes all rungs of a ladder: every size with every step or tolerance, degree and scheme. Default sizes are
/// 1, 2 and 4 times the scene's. If the .geo sets its own sizes, sizes are factors on these; for a .msh there
/// is only one size, its own. If time.step is a number, the default steps are 1, 2 and 4 times this number,
/// and there are no default tolerances. If time.step is "auto", the default tolerances are 1, 4 and 16 times
/// the scene's, and there are no default steps. Steps are rounded so that they divide time.end. A named
/// scheme applies to every contact; by default each contact keeps its scheme. Throws UserError.
std::vector<Rung> all_rungs(const scene::Scene& scene, const Choice& choice);

/// Rung with the scene's own size, steps, degree and scheme.
Rung own_rung(const scene::Scene& scene);

/// Returns the scene with the size, steps, degree and scheme of a rung.
scene::Scene on_rung(const scene::Scene& scene, const Rung& rung);

/// Exponent p of the law that a step with a direct solver takes a time proportional to n^p for n unknowns.
/// Measured in 2D and 3D by ./dev bench scaling, space.
constexpr double step_power(int dim) { return dim == 2 ? 1.2 : 1.4; }

/// Number proportional to the number of unknowns of a rung.
double relative_unknowns(const Rung& rung, int dim);

/// Number proportional to the run time of a rung; comparable among rungs that all have steps of equal length,
/// or all steps of varying length.
double work(const Rung& rung, int dim);

/// Describes a rung: "size 0.5, step 5e-05, degree 1" or "size 0.5, tolerance 0.01, degree 1", with the
/// scheme unless that is contact-implicit.
std::string words(const Rung& rung, const scene::Scene& scene);
/// Describes the steps of a rung: "step 5e-05" or "tolerance 0.01".
std::string words_of_step(const Rung& rung, const scene::Scene& scene);
/// Keys that make a scene of the same scheme that of the rung, for a user to copy: "mesh.size = 0.5,
/// mesh.degree = 1, time.step = 0.0001973684211". The step has so many digits that it divides time.end.
std::string keys(const Rung& rung, const scene::Scene& scene);

} // namespace signorini::accuracy
