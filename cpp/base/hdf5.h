// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <array>
#include <cerrno>
#include <filesystem>
#include <hdf5.h>
#include <span>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

namespace signorini {

/// Sole owner of an HDF5 identifier; the destructor closes the identifier by the function passed.
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

/// Opens a file for reading. Returns an invalid handle if that fails. Switches off HDF5's printing of its
/// error stack, as create_hdf5() does: callers report a failure in one sentence.
inline Hdf5Handle open_hdf5(const std::filesystem::path& file) {
  H5Eset_auto(H5E_DEFAULT, nullptr, nullptr);
  return {H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
}

/// Creates a file with a list of access properties. Returns an invalid handle if that fails. `mode`:
/// H5F_ACC_TRUNC (overwrite) or H5F_ACC_EXCL (fail if the file exists).
inline Hdf5Handle create_hdf5(const std::filesystem::path& file, unsigned mode, hid_t access) {
  H5Eset_auto(H5E_DEFAULT, nullptr, nullptr);
  return {H5Fcreate(file.c_str(), mode, H5P_DEFAULT, access), H5Fclose};
}

/// Reason why a call of HDF5 failed: the text of errno, or `otherwise` if errno is 0. Set errno to 0 before
/// the call.
inline std::string hdf5_failure(const std::string& otherwise = "HDF5 failed") {
  return errno != 0 ? std::generic_category().message(errno) : otherwise;
}

/// HDF5's type for values of type T in memory: double, char (bytes of a text) or 64-bit integers.
template <class T>
hid_t native_type() {
  if constexpr (std::is_same_v<T, double>)
    return H5T_NATIVE_DOUBLE;
  else if constexpr (std::is_same_v<T, char>)
    return H5T_NATIVE_UCHAR;
  else
    return H5T_NATIVE_INT64;
}

/// Reads a whole dataset, row by row, into a vector or a string, which is resized. Returns false if that
/// fails.
template <class Sequence>
bool read_whole(hid_t dataset, Sequence& values) {
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  const hssize_t count = space ? H5Sget_simple_extent_npoints(space) : -1;
  if (count < 0)
    return false;
  values.resize(static_cast<std::size_t>(count));
  return values.empty() || H5Dread(dataset, native_type<typename Sequence::value_type>(), H5S_ALL, H5S_ALL,
                                   H5P_DEFAULT, values.data()) >= 0;
}

/// Returns two data spaces for a transfer of one row: the row in the table, and `columns` numbers in memory.
/// The first is invalid if the table has no such row.
inline std::array<Hdf5Handle, 2> row_spaces(hid_t table, std::size_t row, hsize_t columns) {
  const std::array<hsize_t, 2> start{row, 0}, count{1, columns};
  Hdf5Handle space(H5Dget_space(table), H5Sclose);
  if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) < 0)
    space = Hdf5Handle(H5I_INVALID_HID, H5Sclose);
  return {std::move(space), Hdf5Handle(H5Screate_simple(1, &columns, nullptr), H5Sclose)};
}

/// Reads one row of a table of doubles into `values` (columns). Returns false if that fails.
inline bool read_row(hid_t table, std::size_t row, std::span<double> values) {
  const auto [in_file, in_memory] = row_spaces(table, row, values.size());
  return H5Dread(table, H5T_NATIVE_DOUBLE, in_memory, in_file, H5P_DEFAULT, values.data()) >= 0;
}

/// Writes `values` (columns) to one row of a table of doubles. Returns false if that fails.
inline bool write_row(hid_t table, std::size_t row, std::span<const double> values) {
  const auto [in_file, in_memory] = row_spaces(table, row, values.size());
  return H5Dwrite(table, H5T_NATIVE_DOUBLE, in_memory, in_file, H5P_DEFAULT, values.data()) >= 0;
}

/// Creates a list of dataset properties without time stamps and fill values, so that equal runs write equal
/// bytes.
inline Hdf5Handle plain_layout() {
  Hdf5Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_fill_time(list, H5D_FILL_TIME_NEVER);
  H5Pset_obj_track_times(list, false);
  return list;
}

inline Hdf5Handle make_group(hid_t place, const char* name) {
  return {H5Gcreate(place, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose};
}

/// Creates a dataset of doubles, bytes or 64-bit integers with the property list `layout` and writes `values`
/// to it. Returns false if that fails.
template <class T>
bool write_whole(hid_t place, const char* name, const std::vector<hsize_t>& shape, const T* values,
                 hid_t layout) {
  const hid_t stored = std::is_same_v<T, double> ? H5T_IEEE_F64LE
                       : std::is_same_v<T, char> ? H5T_STD_U8LE
                                                 : H5T_STD_I64LE;
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
  Hdf5Handle set(H5Dcreate(place, name, stored, space, H5P_DEFAULT, layout, H5P_DEFAULT), H5Dclose);
  const bool written = set && H5Dwrite(set, native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0;
  return set.finish() && written;
}

/// Numbers of rows and columns of a dataset; both are zero unless the dataset has two dimensions.
inline std::array<hsize_t, 2> shape(hid_t dataset) {
  std::array<hsize_t, 2> rows_columns{};
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  if (space && H5Sget_simple_extent_ndims(space) == 2)
    H5Sget_simple_extent_dims(space, rows_columns.data(), nullptr);
  return rows_columns;
}

} // namespace signorini
