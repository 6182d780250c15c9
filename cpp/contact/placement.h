// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"

namespace signorini::contact {

/// Throws UserError if no position of some node satisfies the constraints of all its obstacles, for the ψ (m)
/// of time t. Collective.
void require_room(const ContactPairs& pairs, std::span<const double> psi, double t,
                  ContactPairs::NodeWork& work);

/// Moves nodes that start inside an obstacle for which contact.initial asks for it to the closest position
/// that all obstacles of the node allow. Throws UserError naming the deepest node inside any other obstacle,
/// or one that has no such position. Collective.
void place_outside(const ContactPairs& pairs, Vec y);

} // namespace signorini::contact
