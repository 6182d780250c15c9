#pragma once
#include "contact/constraints.h"

namespace signorini::contact {

/// Massless contact (docs/method.md section 2; Khenous, Laborde, Renard 2008): EᵀME, where E replaces the velocity of
/// each contact node in the directions of its constraints by what nodes within the body extrapolate there. The
/// contact nodes so carry no mass in these directions. E keeps every velocity field that is linear in space, so
/// the mass, its first moments and the moments of inertia stay; where too few nodes are near for that, only the
/// mass does. `massless` tells of each of the scene's obstacles whether its candidates are meant. In blocks
/// (BAIJ), with the pattern of M and entries between the nodes extrapolated from. Collective. Throws UserError
/// if a candidate has no neighbour in the body that is none.
petsc::Matrix massless(const fem::Space& space, const Constraints& constraints,
                       const std::vector<bool>& massless, Mat M);

} // namespace signorini::contact
