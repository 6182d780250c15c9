// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/rungs.h"
#include "base/error.h"
#include "base/text.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <set>

namespace signorini::accuracy {
namespace {

scene::TimeScheme time_scheme(scene::ContactScheme scheme) {
  return scheme == scene::ContactScheme::contact_stabilized ? scene::TimeScheme::contact_stabilized
                                                            : scene::TimeScheme::contact_implicit;
}

/// Returns the mass of a scene's contact on rungs of a contact scheme: its own on those of the scene's
/// scheme.
scene::ContactMass mass_on_rung(const scene::Scene& scene, const scene::Contact& contact,
                                scene::ContactScheme scheme) {
  if (scheme == scene.contact_scheme())
    return contact.mass;
  return scheme == scene::ContactScheme::massless ? scene::ContactMass::massless
                                                  : scene::ContactMass::consistent;
}

std::vector<scene::ContactScheme> schemes(const scene::Scene& scene, const std::vector<std::string>& given) {
  std::vector<std::string> allowed = scene::all_names<scene::ContactScheme>();
  allowed.pop_back(); // mixed: a scene may have it, an option may not name it
  std::vector<scene::ContactScheme> schemes;
  for (const std::string& name : given) {
    const auto found = std::ranges::find(allowed, name);
    if (found == allowed.end())
      throw UserError(fmt::format("--schemes: found \"{}\"; choices: {}", name, list(allowed)));
    if (found != allowed.begin() && scene.contacts.empty())
      throw UserError(fmt::format("--schemes: found \"{}\" in a scene without contact, where the scheme has "
                                  "no effect; leave --schemes out or choose {}",
                                  name, allowed.front()));
    schemes.push_back(static_cast<scene::ContactScheme>(found - allowed.begin()));
  }
  return schemes;
}

template <class T>
std::vector<T> or_default(const std::vector<T>& given, const std::vector<T>& otherwise) {
  return given.empty() ? otherwise : given;
}

/// Number of steps to time.end whose length is nearest to the requested one.
int steps_of(double tau, double end) {
  const double steps = std::round(end / tau);
  if (!(steps <= scene::Time::most_steps))
    throw UserError(fmt::format(
        "--steps: found {} s, which gives {:.10g} steps until time.end = {:.10g} s; choose a length that "
        "gives 1 to {} steps",
        tau, end / tau, end, scene::Time::most_steps));
  return std::max(1, static_cast<int>(steps));
}

void require_positive(const std::vector<double>& values, const char* option, const char* unit) {
  for (double value : values)
    if (!(value > 0 && std::isfinite(value)))
      throw UserError(fmt::format("{}: found {}; expected numbers above 0 {}", option, value, unit));
}

/// Makes a rung for each step and tolerance, without sizes.
std::vector<Rung> rungs_in_time(const scene::Time& time, const Choice& choice) {
  constexpr std::array multiples{4.0, 2.0, 1.0};
  std::vector<double> steps, tolerances;
  for (const double multiple : multiples)
    if (time.automatic())
      tolerances.push_back(std::min(scene::Time::most_tolerance, multiple * multiple * time.tolerance));
    else
      steps.push_back(multiple * time.step);
  std::vector<Rung> rungs;
  for (const double tau : or_default(choice.steps, steps))
    rungs.push_back({.steps = steps_of(tau, time.end)});
  for (const double tolerance : or_default(choice.tolerances, tolerances))
    rungs.push_back({.tolerance = tolerance});
  return rungs;
}

} // namespace

Rung Rung::with_steps(double factor) const {
  Rung changed = *this;
  if (has_varying_steps())
    changed.tolerance = std::min(scene::Time::most_tolerance, factor * factor * tolerance);
  else
    changed.steps = static_cast<int>(std::min<double>(std::ceil(steps / factor), scene::Time::most_steps));
  return changed;
}

SchemeAndMass scheme_and_mass(const scene::Scene& scene, scene::ContactScheme scheme) {
  std::set<std::string> masses;
  for (const scene::Contact& contact : scene.contacts)
    masses.insert(scene::name(mass_on_rung(scene, contact, scheme)));
  return {scene::name(time_scheme(scheme)), masses.empty()      ? scene::name(scene::ContactMass::consistent)
                                            : masses.size() > 1 ? scene::name(scene::ContactScheme::mixed)
                                                                : *masses.begin()};
}

std::vector<Rung> all_rungs(const scene::Scene& scene, const Choice& choice) {
  require_positive(choice.sizes, "--sizes", "m");
  require_positive(choice.steps, "--steps", "s");
  for (double tolerance : choice.tolerances)
    if (!(tolerance >= scene::Time::least_tolerance && tolerance <= scene::Time::most_tolerance))
      throw UserError(fmt::format("--tolerances: found {}; expected numbers from {} to {}", tolerance,
                                  scene::Time::least_tolerance, scene::Time::most_tolerance));
  for (int degree : choice.degrees)
    if (degree != 1 && degree != 2)
      throw UserError(fmt::format("--degrees: found {}; expected 1 or 2", degree));
  const std::vector<scene::ContactScheme> given = schemes(scene, choice.schemes);
  const bool meshed = scene.mesh.meshed();
  if (!choice.sizes.empty() && meshed)
    throw UserError("--sizes: have no effect on a mesh; use a geometry, such as a .geo");
  if (choice.graded && meshed)
    throw UserError("--graded: has no effect on a mesh; use a geometry, such as a .geo");
  const double size = scene.mesh.size.value_or(scene.mesh.scale);
  const std::vector<double> sizes =
      or_default(choice.sizes, meshed ? std::vector{size} : std::vector{4 * size, 2 * size, size});
  std::vector<Rung> rungs;
  for (double width : sizes)
    for (const Rung& in_time : rungs_in_time(scene.time, choice))
      for (int degree : or_default(choice.degrees, {scene.mesh.degree}))
        for (scene::ContactScheme scheme : or_default(given, {scene.contact_scheme()}))
          rungs.push_back({width, in_time.steps, degree, scheme, in_time.tolerance});
  if (choice.graded)
    for (std::size_t i = 0, n = rungs.size(); i < n; ++i) {
      rungs.push_back(rungs[i]);
      rungs.back().graded = true;
    }
  std::ranges::sort(rungs);
  const auto twice = std::ranges::unique(rungs);
  rungs.erase(twice.begin(), twice.end());
  return rungs;
}

Rung own_rung(const scene::Scene& scene) {
  return {.size = scene.mesh.size.value_or(scene.mesh.scale),
          .steps = scene.time.steps,
          .degree = scene.mesh.degree,
          .scheme = scene.contact_scheme(),
          .tolerance = scene.time.automatic() ? scene.time.tolerance : 0};
}

scene::Scene on_rung(const scene::Scene& scene, const Rung& rung) {
  scene::Scene changed = scene;
  if (rung.graded) {
    changed.mesh.file = changed.mesh.graded;
    changed.mesh.scale = rung.size / changed.mesh.size.value_or(changed.mesh.scale);
    changed.mesh.size.reset();
  } else {
    (changed.mesh.size ? *changed.mesh.size : changed.mesh.scale) = rung.size;
  }
  changed.time.steps = rung.steps;
  changed.time.step = rung.has_varying_steps() ? 0 : scene.time.end / rung.steps;
  if (rung.has_varying_steps())
    changed.time.tolerance = rung.tolerance;
  changed.mesh.degree = rung.degree;
  changed.time.scheme = time_scheme(rung.scheme);
  for (std::size_t i = 0; i < scene.contacts.size(); ++i)
    changed.contacts[i].mass = mass_on_rung(scene, scene.contacts[i], rung.scheme);
  return changed;
}

double relative_unknowns(const Rung& rung, int dim) { return std::pow(rung.degree / rung.size, dim); }

double work(const Rung& rung, int dim) {
  return std::pow(relative_unknowns(rung, dim), step_power(dim)) / rung.step_width();
}

std::string words_of_step(const Rung& rung, const scene::Scene& scene) {
  return rung.has_varying_steps() ? fmt::format("tolerance {:.3g}", rung.tolerance)
                                  : fmt::format("step {:.3g}", scene.time.end / rung.steps);
}

std::string keys(const Rung& rung, const scene::Scene& scene) {
  return fmt::format("mesh.{} = {:.4g}, mesh.degree = {}, time.{} = {:.10g}",
                     scene.mesh.size ? "size" : "scale", rung.size, rung.degree,
                     rung.has_varying_steps() ? "tolerance" : "step",
                     rung.has_varying_steps() ? rung.tolerance : scene.time.end / rung.steps);
}

std::string words(const Rung& rung, const scene::Scene& scene) {
  std::string text;
  if (!scene.mesh.meshed())
    text = fmt::format("{} {:.4g}, ", scene.mesh.size ? "size" : "scale", rung.size);
  if (rung.graded)
    text += "graded, ";
  text += fmt::format("{}, degree {}", words_of_step(rung, scene), rung.degree);
  return rung.scheme == scene::ContactScheme::contact_implicit ? text
                                                               : text + ", " + scene::name(rung.scheme);
}

} // namespace signorini::accuracy
