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

/// Creates a dataset (rows × columns), chunked by rows and without a cache, so that a failing write fails
/// within write() and not later.
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
          fmt::format("{}: the folder {} for temporary files is not writable ({}); name a writable folder, "
                      "or unset {}",
                      name, folder, error.message(), name));
    return;
  }
}

ScratchFile::ScratchFile(std::size_t rows, std::size_t columns)
    : folder_(scratch_folder()), rows_(rows), columns_(std::max<std::size_t>(columns, 1)), file_(open()),
      table_(make_table(file_, rows_, columns_)) {
  if (!table_)
    fail("written");
}

Hdf5Handle ScratchFile::open() {
  errno = 0;
  // HDF5 opens files by name only: use a folder to which no other user can write.
  std::string own = (folder_ / "signorini-XXXXXX").string();
  if (!mkdtemp(own.data()))
    fail("written");
  const std::string name = own + "/states";
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  Hdf5Handle file = create_hdf5(name, H5F_ACC_EXCL, access);
  const int error = errno;
  unlink(name.c_str());
  rmdir(own.c_str());
  errno = error;
  if (!file)
    fail("written");
  return file;
}

void ScratchFile::write(std::size_t row, std::span<const double> values) {
  errno = 0;
  if (!values.empty() && !write_row(table_, row, values))
    fail("written");
}

void ScratchFile::read(std::size_t row, std::span<double> values) const {
  errno = 0;
  if (!values.empty() && !read_row(table_, row, values))
    fail("read");
}

void ScratchFile::fail(const char* what) const {
  throw WriteFailure(fmt::format(
      "{}: the states of a motion, {:.3g} MB, cannot be {} there ({}); set TMPDIR to another folder for them",
      folder_.string(), sizeof(double) * 1e-6 * static_cast<double>(rows_ * columns_), what, hdf5_failure()));
}

} // namespace signorini
