// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control.h"
#include <fmt/ranges.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <numeric>
#include <stdexcept>
#include <vector>

/// Conversion of values to numpy arrays, which own them: nothing is copied, and none outlives its memory.
namespace signorini::python {

using Array = nanobind::ndarray<nanobind::numpy, double>;
/// Array from a caller; another type or order is converted.
using Given = nanobind::ndarray<const double, nanobind::c_contig, nanobind::device::cpu>;

/// Makes an array of the entries of `owner` that `values` refers to; takes ownership of `owner`.
template <class Owner>
Array array_of(Owner owner, std::span<double> (*values)(Owner&), std::vector<std::size_t> shape) {
  auto* kept = new Owner(std::move(owner));
  nanobind::capsule last(kept, [](void* object) noexcept { delete static_cast<Owner*>(object); });
  return {values(*kept).data(), shape.size(), shape.data(), last};
}

inline Array array_of(std::vector<double> values, std::vector<std::size_t> shape) {
  return array_of<std::vector<double>>(
      std::move(values), [](std::vector<double>& all) { return std::span(all); }, std::move(shape));
}

inline Array array_of(std::vector<double> values) {
  const std::size_t size = values.size();
  return array_of(std::move(values), {size});
}

/// Makes an array of a control's values (intervals × values).
inline Array array_of(control::Control u) {
  const auto count = static_cast<std::size_t>(u.count());
  const std::size_t size = std::as_const(u).values().size() / count;
  return array_of<control::Control>(std::move(u), [](control::Control& all) { return all.values(); },
                                    {count, size});
}

/// Throws std::invalid_argument unless an array has this shape; another order of axes is refused, too.
inline void require_shape(const Given& given, const std::vector<std::size_t>& shape, const char* meaning) {
  std::vector<std::size_t> found;
  for (std::size_t axis = 0; axis < given.ndim(); ++axis)
    found.push_back(given.shape(axis));
  if (found != shape)
    throw std::invalid_argument(fmt::format("found an array of shape ({}); expected ({}): {}",
                                            fmt::join(found, ", "), fmt::join(shape, ", "), meaning));
}

inline std::span<const double> values_of(const Given& given) { return {given.data(), given.size()}; }

} // namespace signorini::python
