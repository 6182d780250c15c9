// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/hdf5.h"
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace signorini::io {

/// Group /VTKHDF of an HDF5 file: an unstructured grid over time, as the readers of VTK and ParaView expect
/// it (VTKHDF 2.0). All members return false if HDF5 fails. Not collective; source:
/// https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
class VtkhdfGroup {
public:
  /// Numbers of points and cells of a mesh.
  struct Part {
    std::size_t points, cells;
  };
  /// Output time (s), with the part that is its mesh and the first point and cell of that mesh.
  struct Time {
    double time;
    std::size_t part = 0, first_point = 0, first_cell = 0;
  };
  /// Field with a dataset for each time, named by its number, in a group of the same file.
  struct View {
    std::string name, group;    ///< name of the field, and path of the group
    bool in_cells;              ///< whether it has values in cells, else at points
    std::vector<hsize_t> shape; ///< of one dataset: rows × components
  };

  VtkhdfGroup() : group_(H5I_INVALID_HID, H5Gclose) {}
  /// Creates the group in a file.
  [[nodiscard]] bool create(hid_t file);

  /// Writes the meshes of all parts. `points` (n × dim): coordinates, m; `cells` (m × vertices): points of
  /// each cell, counted from the first of its part. Cells are lines, triangles or tetrahedra: 2, 3 or 4
  /// vertices.
  [[nodiscard]] bool write_meshes(const std::vector<Part>& parts, std::size_t dim,
                                  std::span<const double> points, std::size_t vertices,
                                  std::span<const std::int64_t> cells);
  /// Writes one number for each cell of all parts.
  [[nodiscard]] bool write_cell_numbers(const char* name, std::span<const std::int64_t> numbers);
  /// Writes the times; `fields`: views of all times on one mesh, which take no space for values.
  [[nodiscard]] bool write_times(std::span<const Time> times, const std::vector<View>& fields);

private:
  [[nodiscard]] bool write_view(const View& field, std::size_t times);
  Hdf5Handle group_;
  std::size_t vertices_ = 0;         ///< of a cell
  std::vector<std::string> numbers_; ///< names of the numbers of cells
};

/// Name of the dataset of output time `number` in the group of a View; sorting the names sorts the times.
std::string numbered(std::size_t number);

/// Writes a file that is a link to the group of another file in the same folder. Returns false if HDF5 fails.
[[nodiscard]] bool write_vtkhdf_link(const std::filesystem::path& file, const std::string& target);

} // namespace signorini::io
