// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/hdf5.h"
#include "base/petsc.h"
#include "io/field_layout.h"
#include "io/output_folder.h"
#include <span>
#include <string>
#include <vector>

namespace signorini::io {

/// The name of the dataset of the `number`-th stored time; names sort as times do.
[[nodiscard]] std::string numbered(std::size_t number);

/// A field over time in a field file.
struct FieldSeries {
  std::string name;
  Values values;
};

/// The XDMF text that refers to fields over time in the HDF5 file `data` beside it: one collection with a
/// grid for each time, which has the mesh and all fields, as meshio and the readers of VTK and ParaView
/// expect it (those of XDMF 2 resolve no references between grids).
class XdmfIndex {
public:
  XdmfIndex(std::string data, int dim, std::size_t nodes, std::size_t cells);

  /// The text before the first time and after the last one.
  [[nodiscard]] static std::string begin();
  [[nodiscard]] static std::string end();

  /// The grid of the `number`-th time (s), with the datasets `/Function/<name>/<number>`.
  [[nodiscard]] std::string time(std::size_t number, double time, std::span<const FieldSeries> fields) const;

private:
  std::string data_;
  int dim_;
  std::size_t nodes_, cells_;
};

/// Fields over time in an HDF5 file and the XDMF file beside it, at the mesh's own nodes (degree 2: their
/// values at the vertices) or one value for each cell, written one by one during a run. The HDF5 file has the
/// times in `/times` and the fields in `/Function/<field>/<number>`, numbers in the order of time, with
/// leading zeros so that names sort. The XDMF file is written at the end, so that a time costs the same
/// however many came before.
class FieldWriter {
public:
  /// Opens the HDF5 file of `name` (.xdmf) for fields at `times` times at most. Collective. The references
  /// must outlive this object. Throws OutputFailure if the file cannot be written, or the disk has no room
  /// for all.
  FieldWriter(const fem::Space& space, const OutputFolder& folder, const std::string& name,
              std::vector<FieldSeries> fields, std::size_t times);

  /// Writes a field at the `number`-th of the times, `time` (s), from 0 on and in any order: its values that
  /// this rank owns, at the nodes of V or in the cells. Collective. Throws OutputFailure.
  void write(const std::string& field, std::size_t number, double time, std::span<const double> owned);
  void write(const std::string& field, std::size_t number, double time, Vec values);

  /// Moves the times from the `number`-th on one place back; all fields are to be written at the place that
  /// is free then. Collective. Throws UserError.
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
  /// Writes a dataset from data of the type `given`; false if that fails.
  bool put(hid_t place, const char* name, hid_t stored, hid_t given, const std::vector<hsize_t>& shape,
           const void* data) const;
  /// Throws OutputFailure if the disk has no room for so many times. Collective.
  void require_room(std::size_t times) const;

  const fem::Space& space_;
  const OutputFolder& folder_;
  std::string name_, data_; ///< of the two files
  FieldLayout layout_;
  Hdf5Handle file_, layout_list_; ///< on rank 0
  std::vector<FieldSeries> fields_;
  std::vector<Datasets> datasets_; ///< of each field
  std::vector<double> times_;      ///< s
};

} // namespace signorini::io
