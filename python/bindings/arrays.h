// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control.h"
#include <fmt/ranges.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <numeric>
#include <stdexcept>
#include <vector>

/// Values as numpy arrays, which own them: nothing is copied, and none outlives its memory.
namespace signorini::python {

using Array = nanobind::ndarray<nanobind::numpy, double>;
/// What a caller gives; another type or order is converted.
using Given = nanobind::ndarray<const double, nanobind::c_contig, nanobind::device::cpu>;

/// An array of what `values` looks at in `owner`, which moves into it.
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

/// (intervals × values)
inline Array array_of(control::Control u) {
  const auto count = static_cast<std::size_t>(u.count());
  const std::size_t size = std::as_const(u).values().size() / count;
  return array_of<control::Control>(std::move(u), [](control::Control& all) { return all.values(); },
                                    {count, size});
}

/// Throws std::invalid_argument where an array has another shape, if only by its order of axes.
inline void require_shape(const Given& given, const std::vector<std::size_t>& shape, const char* meaning) {
  std::vector<std::size_t> found;
  for (std::size_t axis = 0; axis < given.ndim(); ++axis)
    found.push_back(given.shape(axis));
  if (found != shape)
    throw std::invalid_argument(fmt::format("found an array of shape ({}), but this is ({}), {}",
                                            fmt::join(found, ", "), fmt::join(shape, ", "), meaning));
}

inline std::span<const double> values_of(const Given& given) { return {given.data(), given.size()}; }

} // namespace signorini::python
