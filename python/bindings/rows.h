// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "arrays.h"
#include <cstdint>
#include <span>
#include <vector>

namespace signorini::python {

/// Reorders and scales the places of an array:
/// result(j, i, c) = values[start(i) + j · stride(i) + c] · row(j) · column(i, c), rows × places ×
/// components. numpy's indexing by columns leaves the result in the order of columns; its indexing by a whole
/// table of indices reads three times as much.
class Rows {
public:
  using Places =
      nanobind::ndarray<const std::int64_t, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;

  /// Prepares the order for arrays of `size` entries; `start`, `stride` (places), `row` (rows), `column`
  /// (places × components). Throws std::invalid_argument.
  Rows(std::size_t size, const Places& start, const Places& stride, const Given& row, const Given& column);

  /// Entries of an array to reorder.
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t rows() const { return row_.size(); }
  /// Entries of a row of the result.
  [[nodiscard]] std::size_t width() const { return column_.size(); }

  /// Returns the result (rows × width()). Throws std::invalid_argument if the array has another size.
  [[nodiscard]] std::vector<double> of(std::span<const double> values) const;
  /// Reorders and scales in place, for orders in which every row stays where it is.
  void in_place(std::span<double> values) const;

private:
  /// Calls take(j, row j of the result) for all rows.
  template <class Take>
  void each_row(std::span<const double> values, Take&& take) const;
  template <std::size_t components>
  void fill(std::span<const double> values, std::size_t j, std::vector<double>& row) const;

  std::size_t size_;
  std::vector<std::int64_t> start_, stride_;
  std::vector<double> row_, column_;
};

} // namespace signorini::python
