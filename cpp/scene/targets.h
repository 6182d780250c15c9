// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"

/// Tables and numbers of a scene to which its unknowns belong.
namespace signorini::scene {

/// Index in scene.materials of the material to which an unknown belongs. Throws std::out_of_range if the
/// scene has no such material, which reading a scene excludes.
std::size_t material_of(const Scene& scene, const Unknown& unknown);
/// Index in the material's `prony` of the branch to which an unknown belongs. Throws std::out_of_range if the
/// material has no such branch, which reading a scene excludes.
std::size_t branch_of(const Scene& scene, const Unknown& unknown);
/// Returns the fraction or the time of a branch, whichever the parameter `of` names.
double& number_of(Branch& branch, Parameter of);
/// Index in scene.contacts of the obstacle to which an unknown belongs. Throws std::out_of_range if the scene
/// has no such obstacle, which reading a scene excludes.
std::size_t contact_of(const Scene& scene, const Unknown& unknown);

/// Index in `contacts` of the obstacle named `name`, which must exist.
int obstacle_number(const std::vector<Contact>& contacts, const std::string& name);

/// Index in scene.foundations of the foundation to which an unknown belongs. Throws std::out_of_range if the
/// scene has no such foundation, which reading a scene excludes.
std::size_t foundation_of(const Scene& scene, const Unknown& unknown);

/// Returns the number that an unknown of a material, of a foundation or of the mass of an obstacle stands
/// for.
double& number_of(Scene& scene, const Unknown& unknown);

/// Numbers of an obstacle with mass of the kind `of`, one for all components or one for each; null for the
/// mass, a single number.
std::vector<double>* numbers_of(RigidBody& body, Parameter of);

} // namespace signorini::scene
