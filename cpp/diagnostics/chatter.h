// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/step.h"
#include <string>

namespace signorini::diagnostics {

/// Contact of a motion that comes and goes from step to step.
struct Alternations {
  int closed = 0;      ///< candidates in contact, summed over the steps
  int alternating = 0; ///< of a step that differ from the step before and are again so in the step after
};

/// Counts over the steps 1, 2, … of a motion; entry 0 is the initial state, whose candidates count as open.
Alternations alternations(const std::vector<contact::ContactLinearisation>& contact);

/// Advice on what makes the contact of such a motion depend less abruptly on forces: "try …".
std::string calmer_contact(const step::Stepper& stepper);

} // namespace signorini::diagnostics
