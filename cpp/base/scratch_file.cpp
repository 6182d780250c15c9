// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/scratch_file.h"
#include "base/error.h"
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <fmt/format.h>
#include <system_error>
#include <unistd.h>

namespace signorini {

namespace {

std::filesystem::path scratch_folder() {
  const char* given = std::getenv("TMPDIR");
  return given && *given ? given : "/var/tmp";
}

/// A dataset (rows × columns), chunked by rows and without a cache, so that a write that fails does so in
/// write() and not later.
Hdf5Handle make_table(hid_t file, hsize_t rows, hsize_t columns) {
  const std::array<hsize_t, 2> shape{rows, columns}, chunk{1, columns};
  const Hdf5Handle space(H5Screate_simple(2, shape.data(), nullptr), H5Sclose);
  const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose),
      access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk(layout, 2, chunk.data());
  H5Pset_fill_time(layout, H5D_FILL_TIME_NEVER);
  H5Pset_chunk_cache(access, 0, 0, H5D_CHUNK_CACHE_W0_DEFAULT);
  return {H5Dcreate(file, "states", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, layout, access), H5Dclose};
}

} // namespace

void require_temporary_folder() {
  for (const char* name : {"TMPDIR", "TEMP", "TMP"}) { // in the order of Open MPI
    const char* folder = std::getenv(name);
    if (!folder)
      continue;
    if (!*folder) {
      unsetenv(name); // Open MPI would take it for the root folder
      continue;
    }
    std::error_code error;
    std::filesystem::create_directories(folder, error); // as Open MPI does
    // Not by access(): to root every folder is writable, /proc too.
    std::string trial = fmt::format("{}/signorini-XXXXXX", folder);
    if (!error && (!mkdtemp(trial.data()) || rmdir(trial.c_str()) != 0))
      error = std::error_code(errno, std::generic_category());
    if (error)
      throw UserError(
          fmt::format("{}: found the folder {}, which cannot be written ({}); name one for temporary "
                      "files that can, or unset {}",
                      name, folder, error.message(), name));
    return;
  }
}

ScratchFile::ScratchFile(std::size_t rows, std::size_t columns)
    : folder_(scratch_folder()), rows_(rows), columns_(std::max<std::size_t>(columns, 1)), file_(open()),
      table_(make_table(file_, rows_, columns_)), line_(
                                                      [&] {
                                                        const hsize_t n = columns_;
                                                        return H5Screate_simple(1, &n, nullptr);
                                                      }(),
                                                      H5Sclose) {
  if (!table_ || !line_)
    fail("written");
}

Hdf5Handle ScratchFile::open() {
  H5Eset_auto(H5E_DEFAULT, nullptr, nullptr); // fail() reports errors, in place of HDF5's error stack
  errno = 0;
  // HDF5 opens files by name only: use a folder to which no other user can write.
  std::string own = (folder_ / "signorini-XXXXXX").string();
  if (!mkdtemp(own.data()))
    fail("written");
  const std::string name = own + "/states";
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  Hdf5Handle file(H5Fcreate(name.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, access), H5Fclose);
  const int error = errno;
  unlink(name.c_str());
  rmdir(own.c_str());
  errno = error;
  if (!file)
    fail("written");
  return file;
}

Hdf5Handle ScratchFile::row_of(std::size_t row) const {
  const std::array<hsize_t, 2> start{row, 0}, count{1, columns_};
  Hdf5Handle space(H5Dget_space(table_), H5Sclose);
  H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
  return space;
}

void ScratchFile::write(std::size_t row, std::span<const double> values) {
  errno = 0;
  if (!values.empty() &&
      H5Dwrite(table_, H5T_NATIVE_DOUBLE, line_, row_of(row), H5P_DEFAULT, values.data()) < 0)
    fail("written");
}

void ScratchFile::read(std::size_t row, std::span<double> values) const {
  errno = 0;
  if (!values.empty() &&
      H5Dread(table_, H5T_NATIVE_DOUBLE, line_, row_of(row), H5P_DEFAULT, values.data()) < 0)
    fail("read");
}

void ScratchFile::fail(const char* what) const {
  throw WriteFailure(
      fmt::format("{}: the states of a motion, {:.3g} MB, cannot be {} there ({}); TMPDIR names "
                  "another folder for them",
                  folder_.string(), sizeof(double) * 1e-6 * static_cast<double>(rows_ * columns_), what,
                  errno != 0 ? std::generic_category().message(errno) : "HDF5 failed"));
}

} // namespace signorini
