#include "app/study/ladder.h"
#include "base/error.h"
#include "scene/names.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::study {
namespace {

scene::TimeScheme time_scheme(Scheme scheme) {
  return scheme == Scheme::contact_stabilized ? scene::TimeScheme::contact_stabilized
                                              : scene::TimeScheme::contact_implicit;
}

Scheme own_scheme(const scene::Scene& scene) {
  const auto without = std::ranges::count_if(scene.contacts, &scene::Contact::massless);
  if (without == 0)
    return scene.time.stabilized() ? Scheme::contact_stabilized : Scheme::contact_implicit;
  return without == std::ssize(scene.contacts) ? Scheme::massless : Scheme::mixed;
}

std::vector<Scheme> schemes(const scene::Scene& scene, const std::vector<std::string>& given) {
  std::vector<std::string> allowed = scene::all_names<Scheme>();
  allowed.pop_back(); // mixed is what a scene may have, and nothing to ask for
  std::vector<Scheme> schemes;
  for (const std::string& name : given) {
    const auto found = std::ranges::find(allowed, name);
    if (found == allowed.end())
      throw UserError(fmt::format("--schemes: found \"{}\", allowed: {}", name, scene::list(allowed)));
    if (found != allowed.begin() && scene.contacts.empty())
      throw UserError(fmt::format(
          "--schemes: found \"{}\" in a scene without contact, where it makes no difference, allowed is {}",
          name, allowed.front()));
    schemes.push_back(static_cast<Scheme>(found - allowed.begin()));
  }
  return schemes;
}

template <class T>
std::vector<T> or_default(const std::vector<T>& given, const std::vector<T>& otherwise) {
  return given.empty() ? otherwise : given;
}

/// The whole number of steps to time.end whose length is nearest.
int steps_of(double tau, double end) {
  const double steps = std::round(end / tau);
  if (!(steps <= scene::Time::most_steps))
    throw UserError(fmt::format(
        "--steps: found {} s, which makes {:.10g} steps to time.end = {:.10g} s, allowed are 1 to {}", tau,
        end / tau, end, scene::Time::most_steps));
  return std::max(1, static_cast<int>(steps));
}

void require_positive(const std::vector<double>& values, const char* option, const char* unit) {
  for (double value : values)
    if (!(value > 0 && std::isfinite(value)))
      throw UserError(fmt::format("{}: found {}, allowed are numbers above 0 {}", option, value, unit));
}

} // namespace

SchemeAndMass scheme_and_mass(Scheme scheme) {
  const bool own = scheme == Scheme::massless || scheme == Scheme::mixed;
  return {scene::name(time_scheme(scheme)),
          own ? scene::name(scheme) : scene::name(scene::ContactMass::consistent)};
}

std::vector<Rung> ladder(const scene::Scene& scene, const Choice& choice) {
  require_positive(choice.sizes, "--sizes", "m");
  require_positive(choice.steps, "--steps", "s");
  for (int degree : choice.degrees)
    if (degree != 1 && degree != 2)
      throw UserError(fmt::format("--degrees: found {}, allowed are 1 and 2", degree));
  const std::vector<Scheme> given = schemes(scene, choice.schemes);
  const bool meshed = scene.mesh.file.extension() == ".msh";
  if (!choice.sizes.empty() && meshed)
    throw UserError("--sizes: have no effect on a .msh, which is meshed already; allowed with a .geo");
  const double step = scene.time.step, size = scene.mesh.size.value_or(scene.mesh.scale);
  const std::vector<double> sizes =
      or_default(choice.sizes, meshed ? std::vector{size} : std::vector{4 * size, 2 * size, size});
  std::vector<Rung> rungs;
  for (double width : sizes)
    for (double tau : or_default(choice.steps, {4 * step, 2 * step, step}))
      for (int degree : or_default(choice.degrees, {scene.mesh.degree}))
        for (Scheme scheme : or_default(given, {own_scheme(scene)}))
          rungs.push_back({width, steps_of(tau, scene.time.end), degree, scheme});
  std::ranges::sort(rungs);
  const auto twice = std::ranges::unique(rungs);
  rungs.erase(twice.begin(), twice.end());
  return rungs;
}

scene::Scene on_rung(const scene::Scene& scene, const Rung& rung) {
  scene::Scene changed = scene::resized(scene, rung.size, rung.steps);
  changed.mesh.degree = rung.degree;
  changed.time.scheme = time_scheme(rung.scheme);
  if (rung.scheme != Scheme::mixed)
    for (scene::Contact& contact : changed.contacts)
      contact.mass =
          rung.scheme == Scheme::massless ? scene::ContactMass::massless : scene::ContactMass::consistent;
  return changed;
}

double relative_unknowns(const Rung& rung, int dim) { return std::pow(rung.degree / rung.size, dim); }

double work(const Rung& rung, int dim) {
  return rung.steps * std::pow(relative_unknowns(rung, dim), step_power(dim));
}

std::string words(const Rung& rung, const scene::Scene& scene) {
  std::string text;
  if (scene.mesh.file.extension() != ".msh")
    text = fmt::format("{} {:.4g}, ", scene.mesh.size ? "size" : "scale", rung.size);
  text += fmt::format("step {:.3g}, degree {}", scene.time.end / rung.steps, rung.degree);
  return rung.scheme == Scheme::contact_implicit ? text : text + ", " + scene::name(rung.scheme);
}

} // namespace signorini::study
