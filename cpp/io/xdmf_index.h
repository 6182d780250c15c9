// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "io/field_layout.h"
#include <span>
#include <string>

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

} // namespace signorini::io
