// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/contact_loss.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::diagnostics {

namespace {

/// Of the largest energy: beyond what the default accuracies leave, and well below what a restitution shows.
constexpr double small_loss = 0.03;

} // namespace

std::vector<Warning> contact_loss(const step::Stepper& stepper, const scene::Scene& scene,
                                  double contact_work, double largest_energy) {
  const double part = largest_energy > 0 ? -contact_work / largest_energy : 0;
  const auto moves = [](const scene::Contact& one) { return scene::moves(one.obstacle); };
  if (!(part > small_loss) || std::ranges::any_of(scene.contacts, moves))
    return {};
  return {{"energy lost in contact",
           fmt::format(
               "contact took {:.2g} of the largest energy of the motion, {:.3g} {}, though its obstacles "
               "are at rest: an error, which falls with the step ({}) to {:.1e} s, in which a wave crosses "
               "an element in contact, and from there on with mesh.size or, where contact.mass is "
               "\"massless\", with the step still",
               part, largest_energy, stepper.space().dim() == 2 ? "J/m" : "J",
               scene.time.automatic() ? "time.tolerance" : "time.step", stepper.wave_time()),
           part, small_loss}};
}

} // namespace signorini::diagnostics
