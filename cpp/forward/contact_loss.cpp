// SPDX-License-Identifier: GPL-3.0-or-later
#include "forward/contact_loss.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::forward {

namespace {

/// Of the largest energy: beyond what the default accuracies leave, and well below what a restitution shows.
constexpr double small_loss = 0.03;

} // namespace

ContactLoss::ContactLoss(const Stepper& stepper, const scene::Scene& scene)
    : stepper_(stepper), scene_(scene),
      rest_(std::ranges::none_of(scene.contacts,
                                 [](const scene::Contact& one) { return scene::moves(one.obstacle); })) {}

void ContactLoss::observe(const StepBalance& balance) {
  largest_ = std::max(largest_, balance.kinetic_energy + balance.elastic_energy);
  lost_ -= balance.contact_work;
}

std::vector<Warning> ContactLoss::warnings() const {
  const double part = largest_ > 0 ? lost_ / largest_ : 0;
  if (!rest_ || !(part > small_loss))
    return {};
  return {{"energy lost in contact",
           fmt::format(
               "contact took {:.2g} of the largest energy of the motion, {:.3g} {}, though its obstacles "
               "are at rest: an error, which falls with the step ({}) to {:.1e} s, in which a wave crosses "
               "an element in contact, and from there on with mesh.size or, where contact.mass is "
               "\"massless\", with the step still",
               part, largest_, stepper_.space().dim() == 2 ? "J/m" : "J",
               scene_.time.automatic() ? "time.tolerance" : "time.step", stepper_.wave_time()),
           part, small_loss}};
}

} // namespace signorini::forward
