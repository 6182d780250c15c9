// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <cmath>
#include <map>
#include <string>
#include <vector>

/// Accuracy against cost: a ladder of runs of one scene, their errors and observed orders.
namespace signorini::accuracy {

/// One run of a ladder.
struct Rung {
  double size = 1; ///< element size, m; without mesh.size the scale of the .geo's own sizes
  int steps = 0;   ///< number of steps of one length; 0: chosen by the motion
  int degree = 1;
  scene::ContactScheme scheme = scene::ContactScheme::contact_implicit;
  double tolerance = 0; ///< time.tolerance of steps that the motion chooses, else 0
  bool graded = false;  ///< sizes vary with the error (Mesh::graded); as many elements as a mesh of `size`

  [[nodiscard]] bool chooses_steps() const { return tolerance > 0; }
  /// Width of the steps; the error in time falls as its square. It is the part of the whole time that a step
  /// takes or, if the motion chooses steps, the square root of their tolerance.
  [[nodiscard]] double step_width() const { return chooses_steps() ? std::sqrt(tolerance) : 1.0 / steps; }
  /// This rung with steps, on the average, `factor` times as wide; whole numbers of steps are rounded up.
  [[nodiscard]] Rung with_steps(double factor) const;

  friend auto operator<=>(const Rung&, const Rung&) = default;
};

/// Values that make up a ladder; an empty list stands for the default.
struct Choice {
  std::vector<double> sizes{}, steps{}; ///< m, s
  std::vector<int> degrees{};
  std::vector<std::string> schemes{};  ///< names of all but mixed
  std::vector<double> tolerances = {}; ///< tolerances of steps that the motion chooses
  bool graded = false;                 ///< whether to add the same rungs with sizes that vary
};

/// Names of a rung's time.scheme and contact.mass, which is "mixed" where it differs between contacts.
struct SchemeAndMass {
  std::string scheme, mass;
};
SchemeAndMass scheme_and_mass(scene::ContactScheme scheme);

/// All rungs of a choice: every size with every step, tolerance, degree and scheme. The default is the
/// scene's own with twice and four times its size and step. With time.step = "auto" it has four and sixteen
/// times its tolerance and no steps of one length, else no tolerance. Where the .geo sets its own sizes they
/// are scales of these; a .msh has one. Graded meshes are added to those of one size. Steps are the nearest
/// that divide time.end. A named scheme applies to every contact; without one each contact keeps the scene's.
/// Throws UserError.
std::vector<Rung> all_rungs(const scene::Scene& scene, const Choice& choice);

/// The rung of the scene's own size, steps, degree and scheme.
Rung own_rung(const scene::Scene& scene);

/// The scene with the size, step, degree and scheme of a rung.
scene::Scene on_rung(const scene::Scene& scene, const Rung& rung);

/// Exponent in the unknowns of the time of a step with a factor, in 2D and 3D: ./dev bench scaling, space.
constexpr double step_power(int dim) { return dim == 2 ? 1.2 : 1.4; }

/// A number to which the unknowns of a rung are proportional.
double relative_unknowns(const Rung& rung, int dim);

/// A number to which the time of a rung is proportional, among rungs with the same kind of steps.
double work(const Rung& rung, int dim);

/// The rung in words: "size 0.5, step 5e-05, degree 1" or "size 0.5, tolerance 0.01, degree 1", with the
/// scheme if it is not contact-implicit.
std::string words(const Rung& rung, const scene::Scene& scene);
/// The steps in words: "step 5e-05" or "tolerance 0.01".
std::string words_of_step(const Rung& rung, const scene::Scene& scene);

} // namespace signorini::accuracy
