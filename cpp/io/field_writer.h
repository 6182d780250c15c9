// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/hdf5.h"
#include "base/petsc.h"
#include "fem/space.h"
#include "io/output_folder.h"
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace signorini::io {

/// Kinds of stored fields: vectors at the nodes or in the cells, and values of other shapes.
enum class Values { nodal, cellwise, nodal_scalar, cellwise_scalar, cellwise_tensor };

/// Whether a field has a value for each cell, else for each node.
[[nodiscard]] bool in_cells(Values values);

/// Mesh in the format of field files, nodes and cells in the order of the ranks, and the values of fields in
/// that order, on rank 0. Its nodes are the mesh's own: the vertices for degree 2 too.
class FieldLayout {
public:
  /// Collective. `space` must outlive this object.
  explicit FieldLayout(const fem::Space& space);

  /// Numbers of nodes, cells and rows on all ranks together.
  [[nodiscard]] std::size_t nodes() const { return nodes_.total(); }
  [[nodiscard]] std::size_t cells() const { return cells_.total(); }
  [[nodiscard]] std::size_t rows(Values values) const { return in_cells(values) ? cells() : nodes(); }

  /// Coordinates (nodes × dim), m, and the nodes of each cell (cells × (dim + 1)); empty on all ranks but 0.
  /// Collective.
  [[nodiscard]] std::vector<double> points() const;
  [[nodiscard]] std::vector<std::int64_t> topology() const;

  /// Gathers the values that each rank owns, at the nodes of V or in the cells, as rows in the shape of
  /// stored values. Valid on rank 0 until the next call. Collective.
  [[nodiscard]] std::span<const double> gather(Values values, std::span<const double> owned);

private:
  /// Nodes or cells: `own` are the places of this rank's rows among the values that it owns.
  struct Rows {
    std::vector<std::size_t> own;
    std::vector<int> counts, starts; ///< number and start of each rank's rows
    [[nodiscard]] std::size_t total() const {
      return static_cast<std::size_t>(starts.back()) + static_cast<std::size_t>(counts.back());
    }
  };
  /// Counts the rows of all ranks. Collective.
  [[nodiscard]] Rows rows_of(std::vector<std::size_t> own) const;
  /// Gathers rows of `columns` entries each on rank 0. Collective.
  template <class T>
  void gather(const Rows& rows, std::size_t columns, const std::vector<T>& mine, std::vector<T>& all) const;

  const fem::Space& space_;
  Rows nodes_, cells_;
  std::vector<double> mine_, all_; ///< buffers
};

/// A field over time in a field file.
struct FieldSeries {
  std::string name;
  Values values;
};

/// Fields over time in an HDF5 file and the XDMF file beside it, written one by one during a run. They have
/// values at the mesh's own nodes (degree 2: at the vertices) or one value for each cell. The HDF5 file has
/// the times in `/times` and the fields in `/Function/<field>/<number>`, numbers in the order of time, with
/// leading zeros so that names sort. The XDMF file is written at the end, so that a time costs the same
/// however many came before.
class FieldWriter {
public:
  /// Opens the HDF5 file of `name` (.xdmf) for fields at `times` times at most. Collective. The references
  /// must outlive this object. Throws OutputFailure if the file cannot be written, or the disk has no room
  /// for all.
  FieldWriter(const fem::Space& space, const OutputFolder& folder, const std::string& name,
              std::vector<FieldSeries> fields, std::size_t times);

  /// Writes a field at `time` (s), the output time `number`, counted from 0; calls may come in any order.
  /// `owned`: its values that this rank owns, at the nodes of V or in the cells. Collective. Throws
  /// OutputFailure.
  void write(const std::string& field, std::size_t number, double time, std::span<const double> owned);
  void write(const std::string& field, std::size_t number, double time, Vec values);

  /// Moves the times from the `number`-th on one place back; all fields must then be written at the free
  /// place. Collective. Throws UserError.
  void make_room(std::size_t number);

  /// Writes the XDMF file; all fields must have been written at the same times, without a gap. Collective.
  /// Throws OutputFailure.
  void close();

private:
  /// Datasets of a field.
  struct Datasets {
    Hdf5Handle group;
    std::size_t written = 0; ///< number of times
  };
  /// Runs `work` on rank 0; throws OutputFailure on all ranks if it returns false. Collective.
  template <class Work>
  void guarded(Work&& work);
  bool open(std::span<const double> points, std::span<const std::int64_t> topology);
  /// The XDMF text of the grid of the `number`-th time: the mesh and all fields.
  [[nodiscard]] std::string grid(std::size_t number) const;
  /// Throws OutputFailure if the disk has no room for so many times. Collective.
  void require_room(std::size_t times) const;

  const fem::Space& space_;
  const OutputFolder& folder_;
  std::string name_, data_; ///< names of the two files
  FieldLayout layout_;
  Hdf5Handle file_, layout_list_; ///< on rank 0
  std::vector<FieldSeries> fields_;
  std::vector<Datasets> datasets_; ///< datasets of each field
  std::vector<double> times_;      ///< s
};

} // namespace signorini::io
