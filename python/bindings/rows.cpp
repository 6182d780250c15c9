// SPDX-License-Identifier: GPL-3.0-or-later
#include "arrays.h"
#include "bindings.h"
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

namespace nb = nanobind;

namespace signorini::python {
namespace {

using Places = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Result = nb::ndarray<double, nb::c_contig, nb::device::cpu>;

template <std::size_t components>
void place_rows(const double* values, std::span<const std::int64_t> start,
                std::span<const std::int64_t> stride, std::span<const double> row, const double* column,
                double* out) {
  const std::size_t width = components * start.size();
  std::vector<double> ordered(width);
  for (std::size_t j = 0; j < row.size(); ++j, out += width) {
    const double factor = row[j];
    double* const to = ordered.data();
    for (std::size_t i = 0; i < start.size(); ++i) {
      const double* const from = values + start[i] + static_cast<std::int64_t>(j) * stride[i];
      // All are read before one is written, or they would not go in pairs.
      std::array<double, components> scaled;
      for (std::size_t c = 0; c < components; ++c)
        scaled[c] = from[c] * factor * column[i * components + c];
      std::copy(scaled.begin(), scaled.end(), to + i * components);
    }
    std::copy(ordered.begin(), ordered.end(), out);
  }
}

/// out(j, i, c) = values[start(i) + j · stride(i) + c] · row(j) · column(i, c): places in another order,
/// their values scaled. `out` may be `values` if every row stays where it is. numpy's indexing by columns
/// leaves the result in the order of columns, and by a whole table of indices reads three times as much.
/// Throws std::invalid_argument.
void rows_of(const Given& values, const Places& start, const Places& stride, const Given& row,
             const Given& column, const Result& out) {
  const std::size_t rows = row.size(), places = start.size(), width = column.size();
  const std::size_t components = places > 0 ? width / places : 1;
  if (stride.size() != places || width != places * components || out.size() != rows * width)
    throw std::invalid_argument("rows: arrays of different sizes");
  const auto fill = components == 1   ? place_rows<1>
                    : components == 2 ? place_rows<2>
                    : components == 3 ? place_rows<3>
                                      : throw std::invalid_argument("rows: more than three components");
  const auto last = static_cast<std::int64_t>(rows) - 1;
  const auto end = static_cast<std::int64_t>(values.size()) - static_cast<std::int64_t>(components);
  for (std::size_t i = 0; i < places && rows > 0; ++i)
    if (start.data()[i] < 0 || stride.data()[i] < 0 || start.data()[i] + last * stride.data()[i] > end)
      throw std::invalid_argument("rows: a place lies outside of the array");
  fill(values.data(), {start.data(), places}, {stride.data(), places}, {row.data(), rows}, column.data(),
       out.data());
}

} // namespace

void bind_rows(nb::module_& module) {
  module.def("rows", rows_of, nb::arg("values"), nb::arg("start"), nb::arg("stride"), nb::arg("row"),
             nb::arg("column"), nb::arg("out").noconvert());
}

} // namespace signorini::python
