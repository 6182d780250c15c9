// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/hdf5.h"
#include "base/petsc.h"
#include "fem/space.h"
#include "io/output_folder.h"
#include "io/vtkhdf.h"
#include "scene/choices.h"
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace signorini::io {

/// Kinds of stored fields, with a value at each node (nodal) or for each cell (cellwise). The values are
/// vectors, unless the name ends with scalar or tensor.
enum class Values { nodal, cellwise, nodal_scalar, cellwise_scalar, cellwise_tensor };

/// Whether a field has a value for each cell; else it has one for each node.
[[nodiscard]] bool in_cells(Values values);

/// Gathers the mesh and the values of fields on rank 0, as field files store them. Nodes and cells are
/// ordered by the rank that owns them. The nodes are the vertices of the mesh, also for elements of degree 2.
class FieldLayout {
public:
  /// Numbers the vertices and cells of a mesh. Collective. `space` must outlive this object.
  explicit FieldLayout(const fem::Space& space);

  /// Number of vertices of the mesh, summed over the ranks.
  [[nodiscard]] std::size_t nodes() const { return nodes_.total(); }
  /// Number of cells of the mesh, summed over the ranks.
  [[nodiscard]] std::size_t cells() const { return cells_.total(); }
  /// Number of rows of a field: cells() if the field has a value for each cell, else nodes().
  [[nodiscard]] std::size_t rows(Values values) const { return in_cells(values) ? cells() : nodes(); }

  /// Gathers the coordinates of the vertices (nodes × dim), m, on rank 0; empty on other ranks. Collective.
  [[nodiscard]] std::vector<double> points() const;
  /// Gathers the vertices of each cell (cells × (dim + 1)) on rank 0; empty on other ranks. Collective.
  [[nodiscard]] std::vector<std::int64_t> topology() const;

  /// Gathers a field on rank 0. `owned`: the values that this rank owns, at the nodes of V or in the cells.
  /// The result has a row for each vertex or cell; vectors are padded to 3 components. It is valid until the
  /// next call, and empty on ranks other than 0. Collective.
  [[nodiscard]] std::span<const double> gather(Values values, std::span<const double> owned);

private:
  /// Distribution over the ranks of a table that has one row for each vertex or cell.
  struct Rows {
    std::vector<std::size_t> own;    ///< for each row of this rank, its index among the values owned here
    std::vector<int> counts, starts; ///< for each rank, its number of rows and the index of its first row
    [[nodiscard]] std::size_t total() const {
      return static_cast<std::size_t>(starts.back()) + static_cast<std::size_t>(counts.back());
    }
  };
  /// Determines the distribution of rows from the indices `own` on each rank. Collective.
  [[nodiscard]] Rows rows_of(std::vector<std::size_t> own) const;
  /// Gathers rows of `columns` entries each on rank 0. Collective.
  template <class T>
  void gather(const Rows& rows, std::size_t columns, const std::vector<T>& mine, std::vector<T>& all) const;

  const fem::Space& space_;
  Rows nodes_, cells_;
  std::vector<double> mine_, all_; ///< buffers of gather(): rows of this rank, rows of all ranks
};

/// A field that is stored at several times in a field file.
struct FieldSeries {
  std::string name;
  Values values; ///< kind of the field
};

/// Writes fields at the output times of a run into an HDF5 file, and what ParaView needs to find them there:
/// an XDMF file, a VTKHDF file or both. Fields have values at the vertices of the mesh, also for elements of
/// degree 2, or one value for each cell. The HDF5 file has the times in `/times` and the fields in
/// `/Function/<field>/<number>`. The numbers ascend with time and have leading zeros, so that sorting the
/// names sorts the times. With VTKHDF it also has a group /VTKHDF with views of the fields; without XDMF the
/// HDF5 file is the VTKHDF file itself. Only close() writes the XDMF file and the views, so that the cost of
/// an output time does not grow with the number of earlier ones.
class FieldWriter {
public:
  /// Creates the HDF5 file for `fields` at up to `times` output times. `name`: name of the files, without
  /// extension; `formats`: at least one. Throws OutputFailure if the file cannot be written or the disk lacks
  /// space for all times. Collective. `space` and `folder` must outlive this object.
  FieldWriter(const fem::Space& space, const OutputFolder& folder, const std::string& name,
              std::vector<FieldSeries> fields, std::size_t times,
              const std::vector<scene::FieldFormat>& formats);

  /// Writes the values of a field at `time` (s). `number`: index of this output time, from 0; output times
  /// may be written in any order. `owned`: the values that this rank owns, at the nodes of V or in the cells.
  /// Throws OutputFailure. Collective.
  void write(const std::string& field, std::size_t number, double time, std::span<const double> owned);
  void write(const std::string& field, std::size_t number, double time, Vec values);

  /// Increases the numbers of all output times from `number` on by one. Afterwards all fields must be
  /// written at the free `number`. Throws OutputFailure. Collective.
  void make_room(std::size_t number);

  /// Closes the HDF5 file and writes the files that refer to it. All fields must have been written at every
  /// output time. Throws OutputFailure. Collective.
  void close();

private:
  /// Datasets of one field in the HDF5 file.
  struct Datasets {
    Hdf5Handle group;
    std::size_t written = 0; ///< number of output times written
  };
  /// Runs `work` on rank 0; throws OutputFailure on all ranks if `work` returns false. Collective.
  template <class Work>
  void guarded(Work&& work);
  bool open(std::span<const double> points, std::span<const std::int64_t> topology);
  /// Writes times and views of the fields to the group /VTKHDF. Returns false if HDF5 fails.
  bool write_views();
  void write_xdmf() const;
  /// XDMF text of the grid at output time `number`: the mesh and all fields.
  [[nodiscard]] std::string grid(std::size_t number) const;
  /// Throws OutputFailure if the disk lacks space for all fields at `times` output times. Collective.
  void require_room(std::size_t times) const;

  const fem::Space& space_;
  const OutputFolder& folder_;
  std::string name_, data_; ///< name without extension, and name of the HDF5 file
  bool xdmf_;               ///< whether an XDMF file is written
  FieldLayout layout_;
  Hdf5Handle file_, layout_list_; ///< HDF5 file and the creation properties of its datasets; on rank 0
  std::vector<FieldSeries> fields_;
  std::vector<Datasets> datasets_;    ///< datasets of each field
  std::vector<double> times_;         ///< output times, s
  std::optional<VtkhdfGroup> vtkhdf_; ///< if a VTKHDF file is written
};

} // namespace signorini::io
