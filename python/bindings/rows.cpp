// SPDX-License-Identifier: GPL-3.0-or-later
#include "arrays.h"
#include "bindings.h"
#include <cstdint>
#include <stdexcept>

namespace nb = nanobind;

namespace signorini::python {
namespace {

using Columns = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Result = nb::ndarray<double, nb::c_contig, nb::device::cpu>;

/// out(j, i) = values[start(i) + j · stride(i)] · row(j) · column(i): columns in another order, scaled.
/// numpy's indexing by columns leaves the result in the order of columns, and by a whole table of indices
/// reads three times as much. Throws std::invalid_argument.
void rows_of(const Given& values, const Columns& start, const Columns& stride, const Given& row,
             const Given& column, const Result& out) {
  const std::size_t rows = row.size(), width = column.size();
  if (start.size() != width || stride.size() != width || out.size() != rows * width)
    throw std::invalid_argument("rows: arrays of different sizes");
  const auto last = static_cast<std::int64_t>(rows) - 1, size = static_cast<std::int64_t>(values.size());
  for (std::size_t i = 0; i < width && rows > 0; ++i)
    if (start.data()[i] < 0 || stride.data()[i] < 0 || start.data()[i] + last * stride.data()[i] >= size)
      throw std::invalid_argument("rows: a column lies outside of the array");
  for (std::size_t j = 0; j < rows; ++j) {
    double* const to = out.data() + j * width;
    const double factor = row.data()[j];
    for (std::size_t i = 0; i < width; ++i)
      to[i] = values.data()[start.data()[i] + static_cast<std::int64_t>(j) * stride.data()[i]] * factor *
              column.data()[i];
  }
}

} // namespace

void bind_rows(nb::module_& module) {
  module.def("rows", rows_of, nb::arg("values"), nb::arg("start"), nb::arg("stride"), nb::arg("row"),
             nb::arg("column"), nb::arg("out").noconvert());
}

} // namespace signorini::python
