// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/quantities.h"
#include "base/error.h"
#include "base/text.h"
#include "diagnostics/contact_forces.h"
#include "diagnostics/largest_stress.h"
#include "trajectory/step_errors.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::accuracy {

namespace {

/// Quantities that diagnostics::ContactFigures measures.
std::vector<Quantity> contact_quantities(const scene::Scene& scene, int dim) {
  const std::string each = scene.mesh.per_depth(dim);
  std::vector<Quantity> all;
  // In axial symmetry the force of a tube has no resultant.
  const auto radial = [&](const scene::Contact& contact) {
    return scene.mesh.axisymmetric() && contact.meets_cylinder();
  };
  const auto add = [&](const std::string& end, const std::string& of, bool resultant) {
    if (resultant)
      all.push_back({"impulse" + end, "impulse of contact" + of, "N s" + each});
    all.push_back({"impulse_duration" + end, "time from 1 to 99 % of the impulse" + of, "s"});
    all.push_back({"sustained_peak" + end, "sustained peak force" + of, "N" + each, false, false, false});
    if (resultant)
      all.push_back({"peak_force" + end, "peak force (two-step mean)" + of, "N" + each, false, false, false});
    all.push_back({"contact_start" + end, "start of contact" + of, "s"});
    all.push_back({"contact_time" + end, "time in contact" + of, "s", false, false, false});
  };
  if (!scene.contacts.empty())
    add("", "", !std::ranges::all_of(scene.contacts, radial));
  if (scene.contacts.size() > 1)
    for (int obstacle = 0; obstacle < std::ssize(scene.contacts); ++obstacle)
      add(diagnostics::obstacle_suffix(obstacle), fmt::format(", obstacle {}", obstacle + 1),
          !radial(scene.contacts[static_cast<std::size_t>(obstacle)]));
  return all;
}

} // namespace

std::vector<Quantity> quantities(const scene::Scene& scene, int dim) {
  std::vector<Quantity> all{{"displacement", "displacement", "m", true}};
  if (scene.objective) {
    all.insert(all.begin(), {"J", "J", ""});
    if (scene.control->space == scene::ControlValues::nodal)
      all.push_back({"gradient", "gradient", "", true});
  }
  all.push_back({of_stress, "largest von Mises stress of all steps", "Pa", false, false, false});
  if (scene.contacts.empty())
    return all;
  std::ranges::move(contact_quantities(scene, dim), std::back_inserter(all));
  all.push_back({of_restitution, "coefficient of restitution", ""});
  const auto rests = [](const scene::Contact& contact) { return !scene::moves(contact); };
  if (std::ranges::all_of(scene.contacts, rests))
    all.push_back({"energy_loss", "energy lost in contact", "", false, true});
  if (scene.exact && scene.exact->pressure)
    all.push_back({"pressure", "pressure at the end", "", false, true});
  return all;
}

bool has(const std::vector<Quantity>& quantities, const std::string& name) {
  return std::ranges::find(quantities, name, &Quantity::name) != quantities.end();
}

bool Quantity::affected_by(const Warning& warning) const {
  if (warning.name == diagnostics::stress_of_the_mesh)
    return name == of_stress;
  return warning.name != trajectory::peak_of_the_mesh || name.starts_with("peak_force") ||
         name.starts_with("sustained_peak");
}

std::string Measured::warning(const Quantity& quantity) const {
  std::string text;
  for (const Warning& warning : warnings)
    if (quantity.affected_by(warning))
      text += fmt::format("{}{}", text.empty() ? "" : "; ", warning.message);
  return text;
}

std::vector<Quantity> named(const std::vector<Quantity>& all, const std::vector<std::string>& names,
                            const char* what) {
  std::vector<std::string> allowed;
  for (const Quantity& quantity : all)
    allowed.push_back(quantity.name);
  std::vector<Quantity> wanted;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(all, name, &Quantity::name);
    if (found == all.end())
      throw UserError(fmt::format("--quantity: found \"{}\"{}; {} of this scene: {}", name,
                                  suggestion(name, allowed), what, list(allowed)));
    if (!has(wanted, name))
      wanted.push_back(*found);
  }
  return wanted;
}

std::vector<Quantity> chosen(const scene::Scene& scene, const std::vector<std::string>& names, int dim) {
  const std::vector<Quantity> all = quantities(scene, dim);
  std::vector<Quantity> wanted = named(all, names, "quantities");
  if (wanted.empty())
    std::ranges::copy_if(all, std::back_inserter(wanted), [&](const Quantity& quantity) {
      using enum scene::StoredField;
      const bool stored = scene.output.field(stress) || scene.output.field(von_mises);
      return quantity.name != "gradient" && quantity.name != of_restitution &&
             (quantity.name != of_stress || stored);
    });
  return wanted;
}

} // namespace signorini::accuracy
