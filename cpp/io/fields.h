#pragma once
#include "fem/space.h"
#include <filesystem>
#include <string>
#include <vector>

namespace signorini::io {

/// A field over time, for output: values[i] at times[i].
struct FieldSeries {
  std::string name; ///< fixed name in the XDMF file
  std::vector<Vec> values;
};

/// Writes fields at `times` to an XDMF file and the HDF5 file beside it, at the mesh's own nodes (degree 2: their values at
/// the vertices). Collective. Throws UserError if the file cannot be written.
void write_fields(const fem::Space& space, const std::filesystem::path& file, const std::vector<double>& times,
                  const std::vector<FieldSeries>& fields);

} // namespace signorini::io
