// SPDX-License-Identifier: GPL-3.0-or-later
#include "rows.h"
#include "bindings.h"
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <stdexcept>

namespace nb = nanobind;

namespace signorini::python {

Rows::Rows(std::size_t size, const Places& start, const Places& stride, const Given& row, const Given& column)
    : size_(size), start_(start.data(), start.data() + start.size()),
      stride_(stride.data(), stride.data() + stride.size()), row_(row.data(), row.data() + row.size()),
      column_(column.data(), column.data() + column.size()) {
  const std::size_t places = start_.size(), components = places > 0 ? width() / places : 1;
  if (stride_.size() != places || width() != places * components || components < 1 || components > 3)
    throw std::invalid_argument("rows: arrays of different sizes");
  const auto last = static_cast<std::int64_t>(rows()) - 1;
  const auto end = static_cast<std::int64_t>(size) - static_cast<std::int64_t>(components);
  for (std::size_t i = 0; i < places && last >= 0; ++i)
    if (start_[i] < 0 || stride_[i] < 0 || start_[i] + last * stride_[i] > end)
      throw std::invalid_argument("rows: start and stride lead outside of the array");
}

template <std::size_t components>
void Rows::fill(std::span<const double> values, std::size_t j, std::vector<double>& row) const {
  const double factor = row_[j];
  for (std::size_t i = 0; i < start_.size(); ++i) {
    const double* const from =
        &values[static_cast<std::size_t>(start_[i] + static_cast<std::int64_t>(j) * stride_[i])];
    // All components are read before one is written; otherwise they would not be processed in pairs.
    std::array<double, components> scaled;
    for (std::size_t c = 0; c < components; ++c)
      scaled[c] = from[c] * factor * column_[i * components + c];
    std::copy(scaled.begin(), scaled.end(), row.data() + i * components);
  }
}

template <class Take>
void Rows::each_row(std::span<const double> values, Take&& take) const {
  if (values.size() != size_)
    throw std::invalid_argument(
        fmt::format("found an array of {} entries; expected {} x {}, the values on all ranks", values.size(),
                    rows(), size_ / std::max<std::size_t>(rows(), 1)));
  const std::size_t components = start_.empty() ? 1 : width() / start_.size();
  std::vector<double> row(width());
  for (std::size_t j = 0; j < rows(); ++j) {
    components == 1   ? fill<1>(values, j, row)
    : components == 2 ? fill<2>(values, j, row)
                      : fill<3>(values, j, row);
    take(j, row);
  }
}

std::vector<double> Rows::of(std::span<const double> values) const {
  std::vector<double> result;
  result.reserve(rows() * width());
  each_row(values, [&](std::size_t, const std::vector<double>& row) {
    result.insert(result.end(), row.begin(), row.end());
  });
  return result;
}

void Rows::in_place(std::span<double> values) const {
  each_row(values, [&](std::size_t j, const std::vector<double>& row) {
    std::ranges::copy(row, values.subspan(j * width()).begin());
  });
}

void bind_rows(nb::module_& module) {
  using InOut = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
  nb::class_<Rows>(module, "Rows")
      .def(nb::init<std::size_t, const Rows::Places&, const Rows::Places&, const Given&, const Given&>())
      .def("of",
           [](const Rows& self, const Given& values) {
             return array_of(self.of(values_of(values)), {self.rows(), self.width()});
           })
      .def(
          "in_place",
          [](const Rows& self, const InOut& values) { self.in_place({values.data(), values.size()}); },
          nb::arg("values").noconvert());
}

} // namespace signorini::python
