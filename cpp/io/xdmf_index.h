// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "io/field_layout.h"
#include <string>
#include <vector>

namespace signorini::io {

/// The name of the dataset of the `number`-th stored time; names sort as times do.
[[nodiscard]] std::string numbered(std::size_t number);

/// The XDMF text that refers to a mesh and to fields over time in the HDF5 file `data` beside it.
class XdmfIndex {
public:
  XdmfIndex(std::string data, int dim, std::size_t nodes, std::size_t cells);

  /// What comes before the fields, with the mesh, and behind them.
  [[nodiscard]] std::string begin() const;
  [[nodiscard]] static std::string end();

  /// A field at all times, s, from its datasets `/Function/<name>/<number>`.
  [[nodiscard]] std::string field(const std::string& name, Values values,
                                  const std::vector<double>& times) const;

private:
  std::string data_;
  int dim_;
  std::size_t nodes_, cells_;
};

} // namespace signorini::io
