// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <array>
#include <hdf5.h>
#include <utility>

namespace signorini {

/// Sole owner of an HDF5 identifier, which it closes.
class Hdf5Handle {
public:
  Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Hdf5Handle() {
    if (id_ >= 0)
      close_(id_);
  }
  Hdf5Handle(Hdf5Handle&& other) noexcept
      : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  /// Closes the identifier and returns whether that succeeded: closing a file writes its remaining data.
  bool finish() {
    const hid_t id = std::exchange(id_, H5I_INVALID_HID);
    return id < 0 || close_(id) >= 0;
  }
  operator hid_t() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Rows and columns of a dataset; zeros unless it has two dimensions.
inline std::array<hsize_t, 2> shape(hid_t dataset) {
  std::array<hsize_t, 2> rows_columns{};
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  if (space && H5Sget_simple_extent_ndims(space) == 2)
    H5Sget_simple_extent_dims(space, rows_columns.data(), nullptr);
  return rows_columns;
}

} // namespace signorini
