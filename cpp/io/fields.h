#pragma once
#include "fem/space.h"
#include "io/output_folder.h"
#include <string>
#include <vector>

namespace signorini::io {

/// A field over time, for output: values[i] at times[i].
struct FieldSeries {
  std::string name; ///< fixed name in the XDMF file
  std::vector<Vec> values;
};

/// Writes fields at `times` to the XDMF file `name` and the HDF5 file beside it, at the mesh's own nodes (degree 2: their
/// values at the vertices). Collective. Throws WriteFailure, on one rank or several, if the files cannot be
/// written.
void write_fields(const fem::Space& space, const OutputFolder& folder, const std::string& name,
                  const std::vector<double>& times, const std::vector<FieldSeries>& fields);

} // namespace signorini::io
