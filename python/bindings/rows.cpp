// SPDX-License-Identifier: GPL-3.0-or-later
#include "arrays.h"
#include "bindings.h"
#include <cstdint>
#include <memory>
#include <stdexcept>

namespace nb = nanobind;

namespace signorini::python {
namespace {

/// Not set to zero before they are written.
struct Values {
  std::unique_ptr<double[]> entries;
  std::size_t size;
};

using Columns = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

/// out(j, i) = values[start(i) + j · stride(i)] · row(j) · column(i): columns in another order, scaled.
/// numpy's indexing by columns leaves the result in the order of columns, and by a whole table of indices
/// reads three times as much. Throws std::invalid_argument.
Array rows_of(const Given& values, const Columns& start, const Columns& stride, const Given& row,
              const Given& column) {
  const std::size_t rows = row.size(), width = column.size();
  if (start.size() != width || stride.size() != width)
    throw std::invalid_argument("rows: arrays of different sizes");
  const auto last = static_cast<std::int64_t>(rows) - 1, size = static_cast<std::int64_t>(values.size());
  for (std::size_t i = 0; i < width && rows > 0; ++i)
    if (start.data()[i] < 0 || stride.data()[i] < 0 || start.data()[i] + last * stride.data()[i] >= size)
      throw std::invalid_argument("rows: a column lies outside of the array");
  auto out = std::make_unique_for_overwrite<double[]>(rows * width);
  for (std::size_t j = 0; j < rows; ++j)
    for (std::size_t i = 0; i < width; ++i)
      out[j * width + i] = values.data()[start.data()[i] + static_cast<std::int64_t>(j) * stride.data()[i]] *
                           row.data()[j] * column.data()[i];
  return array_of<Values>({std::move(out), rows * width},
                          [](Values& all) { return std::span(all.entries.get(), all.size); }, {rows, width});
}

} // namespace

void bind_rows(nb::module_& module) {
  module.def("rows", rows_of, nb::arg("values"), nb::arg("start"), nb::arg("stride"), nb::arg("row"),
             nb::arg("column"));
}

} // namespace signorini::python
