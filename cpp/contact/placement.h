// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"

/// Positions of nodes outside of the obstacles and of other parts.
namespace signorini::contact {

/// Throws UserError if no position of some node satisfies the constraints of all its obstacles. `psi`: gaps
/// of the undeformed body at time t (s), m. Collective.
void require_room(const ContactPairs& pairs, std::span<const double> psi, double t,
                  ContactPairs::NodeWork& work);

/// Changes the initial displacement y of nodes that start inside an obstacle with contact.initial =
/// "project": moves them to the closest position that the constraints of all their obstacles permit. Throws
/// UserError if nodes start inside any other obstacle, naming the deepest of these nodes, and if a node has
/// no such position. Collective.
void place_outside(const ContactPairs& pairs, Vec y);

} // namespace signorini::contact
