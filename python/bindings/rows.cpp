// SPDX-License-Identifier: GPL-3.0-or-later
#include "arrays.h"
#include "bindings.h"
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <nanobind/stl/optional.h>
#include <optional>
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

/// out(j, i) = values[start(i) + j · stride(i)] · factor(j, i), for `rows` rows: columns in another order.
/// numpy's indexing by columns leaves the result in the order of columns, and by a whole table of indices
/// reads three times as much.
Array rows_of(const Given& values, const Columns& start, const Columns& stride, std::size_t rows,
              const std::optional<Given>& factor) {
  const std::size_t width = start.size();
  if (stride.size() != width || (factor && factor->size() != rows * width))
    throw std::invalid_argument("rows: arrays of different sizes");
  if (rows == 0 || width == 0)
    return array_of(std::vector<double>(), {rows, width});
  const auto last = static_cast<std::int64_t>(rows) - 1, size = static_cast<std::int64_t>(values.size());
  for (std::size_t i = 0; i < width; ++i)
    if (start.data()[i] < 0 || stride.data()[i] < 0 || start.data()[i] + last * stride.data()[i] >= size)
      throw std::invalid_argument("rows: a column lies outside of the array");
  auto out = std::make_unique_for_overwrite<double[]>(rows * width);
  for (std::size_t j = 0; j < rows; ++j) {
    double* row = out.get() + j * width;
    for (std::size_t i = 0; i < width; ++i)
      row[i] = values.data()[start.data()[i] + static_cast<std::int64_t>(j) * stride.data()[i]];
    if (factor)
      std::transform(row, row + width, factor->data() + j * width, row, std::multiplies<>());
  }
  return array_of<Values>({std::move(out), rows * width},
                          [](Values& all) { return std::span(all.entries.get(), all.size); }, {rows, width});
}

} // namespace

void bind_rows(nb::module_& module) {
  module.def("rows", rows_of, nb::arg("values"), nb::arg("start"), nb::arg("stride"), nb::arg("rows"),
             nb::arg("factor") = nb::none());
}

} // namespace signorini::python
