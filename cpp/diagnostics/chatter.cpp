// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/chatter.h"
#include <algorithm>

namespace signorini::diagnostics {

Alternations alternations(const std::vector<contact::ContactLinearisation>& contact) {
  Alternations found;
  for (std::size_t k = 1; k < contact.size(); ++k) {
    const auto has = [&](std::size_t step, int i) {
      return std::ranges::binary_search(contact[step].active, i);
    };
    found.closed += static_cast<int>(contact[k].active.size());
    if (k == 1 || k + 1 == contact.size())
      continue;
    for (int i : contact[k].active)
      found.alternating += !has(k - 1, i) && !has(k + 1, i);
    for (int i : contact[k - 1].active)
      found.alternating += !has(k, i) && has(k + 1, i);
  }
  return found;
}

std::string calmer_contact(const step::Stepper& stepper) {
  if (stepper.predictor())
    return "try shorter time steps or more viscosity";
  return scene::takes_mass(stepper.contact_scheme())
             ? "try time.scheme = \"contact-stabilized\" (with contact.mass = \"consistent\")"
             : "try time.scheme = \"contact-stabilized\"";
}

} // namespace signorini::diagnostics
