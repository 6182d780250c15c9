// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace signorini::mesh {

/// Makes physical groups in gmsh's current model, unless it has one. Each surface and curve of a model in the
/// plane, or volume and surface in space, is in the group of its name in the CAD file or, without a name, of
/// its number, such as "surface 7". The group "body" has all bodies, "boundary" what bounds them.
void group_shapes();

} // namespace signorini::mesh
