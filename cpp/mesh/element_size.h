// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/size_field.h"
#include <string>

/// The size that elements are to have, of gmsh's current model.
namespace signorini::mesh {

/// Sets that of all elements, in the unit of the file.
void set_size(double size);

/// Sets that of all elements of a body of which nothing is known yet: a tenth of its longest side.
void set_coarsest_size();

/// Sets those of a field, whose unit is the metre; `metres`: length of the file's unit.
void set_sizes(const SizeField& field, double metres);

/// Throws UserError if the elements of mesh.size in the model, just opened from the file `opened`, are more
/// than can be: gmsh would try for hours. A coarse mesh tells, where the bounding box leaves this open.
void require_few_cells(const scene::Mesh& mesh, const std::string& opened);

} // namespace signorini::mesh
