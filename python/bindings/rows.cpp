// SPDX-License-Identifier: GPL-3.0-or-later
#include "arrays.h"
#include "bindings.h"
#include <algorithm>
#include <cstdint>
#include <functional>
#include <nanobind/stl/optional.h>
#include <optional>
#include <stdexcept>

namespace nb = nanobind;

namespace signorini::python {
namespace {

using Columns = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

/// out(j, i) = values[start(i) + j · stride(i)] / divisor(j, i), for `rows` rows: columns in another order.
/// numpy's indexing by columns leaves the result in the order of columns, and by a whole table of indices
/// reads three times as much.
Array rows_of(const Given& values, const Columns& start, const Columns& stride, std::size_t rows,
              const std::optional<Given>& divisor) {
  const std::size_t width = start.size();
  if (stride.size() != width || (divisor && divisor->size() != rows * width))
    throw std::invalid_argument("rows: arrays of different sizes");
  if (rows == 0 || width == 0)
    return array_of({}, {rows, width});
  const auto last = static_cast<std::int64_t>(rows) - 1, size = static_cast<std::int64_t>(values.size());
  for (std::size_t i = 0; i < width; ++i)
    if (start.data()[i] < 0 || stride.data()[i] < 0 || start.data()[i] + last * stride.data()[i] >= size)
      throw std::invalid_argument("rows: a column lies outside of the array");
  std::vector<double> out(rows * width);
  for (std::size_t j = 0; j < rows; ++j) {
    double* row = out.data() + j * width;
    for (std::size_t i = 0; i < width; ++i)
      row[i] = values.data()[start.data()[i] + static_cast<std::int64_t>(j) * stride.data()[i]];
    if (divisor)
      std::transform(row, row + width, divisor->data() + j * width, row, std::divides<>());
  }
  return array_of(std::move(out), {rows, width});
}

} // namespace

void bind_rows(nb::module_& module) {
  module.def("rows", rows_of, nb::arg("values"), nb::arg("start"), nb::arg("stride"), nb::arg("rows"),
             nb::arg("divisor") = nb::none());
}

} // namespace signorini::python
