// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/study/quantities.h"
#include "app/study/contact_watch.h"
#include "base/error.h"
#include "forward/largest_stress.h"
#include "forward/step_errors.h"
#include "scene/names.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::study {

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
  const auto rests = [](const scene::Contact& contact) { return !scene::moves(contact.obstacle); };
  if (std::ranges::all_of(scene.contacts, rests))
    all.push_back({"energy_loss", "energy lost in contact", "", false, true});
  if (scene.exact && scene.exact->pressure)
    all.push_back({"pressure", "pressure at the end", "", false, true});
  return all;
}

bool Quantity::doubted_by(const forward::Warning& warning) const {
  if (warning.name == forward::stress_of_the_mesh)
    return name == of_stress;
  return warning.name != forward::peak_of_the_mesh || name.starts_with("peak_force") ||
         name.starts_with("sustained_peak");
}

std::string Measured::doubt(const Quantity& quantity) const {
  std::string text;
  for (const forward::Warning& warning : warnings)
    if (quantity.doubted_by(warning))
      text += fmt::format("{}{}", text.empty() ? "" : "; ", warning.message);
  return text;
}

std::vector<Quantity> chosen(const scene::Scene& scene, const std::vector<std::string>& names, int dim) {
  const std::vector<Quantity> all = quantities(scene, dim);
  std::vector<std::string> allowed;
  for (const Quantity& quantity : all)
    allowed.push_back(quantity.name);
  std::vector<Quantity> wanted;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(all, name, &Quantity::name);
    if (found == all.end()) {
      const std::string near = scene::nearest(name, allowed);
      throw UserError(fmt::format("--quantity: found \"{}\"{}, allowed with this scene: {}", name,
                                  near.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", near),
                                  scene::list(allowed)));
    }
    if (std::ranges::find(wanted, name, &Quantity::name) == wanted.end())
      wanted.push_back(*found);
  }
  if (wanted.empty())
    std::ranges::copy_if(all, std::back_inserter(wanted), [&](const Quantity& quantity) {
      using enum scene::StoredField;
      const bool stored = scene.output.field(stress) || scene.output.field(von_mises);
      return quantity.name != "gradient" && (quantity.name != of_stress || stored);
    });
  return wanted;
}

} // namespace signorini::study
