#pragma once
#include "base/petsc.h"
#include "fem/space.h"
#include "scene/scene.h"

namespace signorini::fem {

/// The bilinear forms of forms/viscoelasticity.py, by their names there.
enum class Form { L2, m, a, b, d, d_elastic };

/// Assembles a form on V for a material and time step, no boundary condition applied: a symmetric matrix of
/// PETSc type `type` (rows or blocks), its block size the space dimension. Collective. Throws
/// std::runtime_error if the form asks for a constant that the program does not give.
petsc::Matrix assemble(const Space& space, Form form, const scene::Material& material, double tau,
                       const char* type);

} // namespace signorini::fem
