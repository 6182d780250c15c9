// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"

namespace signorini::contact {

/// Computes the extrapolation E of velocities to contact nodes without mass (docs/method.md section 2;
/// Khenous, Laborde, Renard 2008). E replaces the velocity of such a node by an extrapolation from nodes that
/// keep their mass: in the directions of its contact constraints if contact.mass of the obstacle is
/// "massless", along the obstacle's tangents if it is "massless-tangential". E is a projection, E² = E. It
/// reproduces velocity fields that are linear in space, so that the mass, its first moments and the moments
/// of inertia are unchanged. Where the nearby nodes do not suffice for this, E reproduces constant fields and
/// only the mass is unchanged. Candidates at which the boundary faces away from the obstacle cannot touch it
/// and keep their mass, except with Tresca friction, which acts there too.
///
/// `contacts`: of the scene, one for each obstacle of `pairs`; `pattern`: any matrix with the pattern of a
/// mass matrix. The matrix is stored by rows (AIJ). Collective. Throws UserError if no node near a candidate
/// keeps its mass.
petsc::Matrix velocity_extrapolation(const fem::Space& space, const ContactPairs& pairs,
                                     const std::vector<scene::Contact>& contacts, Mat pattern);

/// Returns the redistributed mass matrix EᵀME in blocks (BAIJ), with the pattern of M and entries between the
/// nodes used for extrapolation. Collective.
petsc::Matrix redistributed_mass(Mat E, Mat M);

/// Adds c_i (I − E_ii) to the diagonal block i of each node in `blocks`, a matrix in blocks. c_i is the
/// diagonal entry of M. With EᵀME, which is singular, the sum is positive definite; where nothing acts on the
/// node in the directions without mass, solutions with the sum are those with EᵀME. Collective.
void add_removed_mass(Mat E, Mat M, Mat blocks);

} // namespace signorini::contact
