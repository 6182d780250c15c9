// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/checkpoint.h"
#include "base/collective.h"
#include "io/output_folder.h"
#include "io/point_match.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

namespace signorini::io {

namespace {

constexpr const char* points_name = "points";

/// Points of a control's values (places × 3), m, on this rank; coincident nodes are moved apart as by
/// distinct_points(). Collective.
std::vector<double> places_of(const control::ControlSpace& controls) {
  if (controls.cellwise())
    return controls.points();
  const std::vector<double> all = distinct_points(controls.space());
  std::vector<double> points;
  for (int node : controls.places())
    points.insert(points.end(), &all[3 * static_cast<std::size_t>(node)],
                  &all[3 * static_cast<std::size_t>(node)] + 3);
  return points;
}

/// Creates a dataset (rows × columns) of an HDF5 type, with a checksum for every chunk; `bytes`: size of a
/// value.
Hdf5Handle make_table(hid_t file, const std::string& name, hid_t type, hsize_t rows, hsize_t columns,
                      std::size_t bytes) {
  constexpr std::size_t chunk_bytes = 1 << 20;
  const std::array<hsize_t, 2> shape{rows, columns};
  const std::array<hsize_t, 2> chunk{
      std::clamp<hsize_t>(chunk_bytes / std::max<hsize_t>(columns * bytes, 1), 1, std::max<hsize_t>(rows, 1)),
      std::max<hsize_t>(columns, 1)};
  const Hdf5Handle space(H5Screate_simple(2, shape.data(), nullptr), H5Sclose);
  const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose),
      link(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(link, 1);
  H5Pset_chunk(layout, 2, chunk.data());
  H5Pset_fletcher32(layout);
  return {H5Dcreate(file, name.c_str(), type, space, link, layout, H5P_DEFAULT), H5Dclose};
}

} // namespace

CheckpointWriter::CheckpointWriter(MPI_Comm comm, const std::filesystem::path& part,
                                   const std::filesystem::path& file)
    : comm_(comm), part_(part), file_(file), out_(H5I_INVALID_HID, H5Fclose) {
  if (rank(comm) != 0)
    return;
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST); // its metadata have checksums
  errno = 0;
  out_ = create_hdf5(part_, H5F_ACC_TRUNC, access);
  if (!out_)
    failure_ = hdf5_failure("HDF5 cannot create it");
}

CheckpointWriter::CheckpointWriter(const control::ControlSpace& controls, const std::filesystem::path& part,
                                   const std::filesystem::path& file)
    : CheckpointWriter(controls.space().comm(), part, file) {
  for (const auto n : gather(comm_, std::vector<int>{static_cast<int>(controls.size())})) {
    starts_.push_back(counts_.empty() ? 0 : starts_.back() + counts_.back());
    counts_.push_back(n);
  }
  (*this)(points_name, gather(comm_, places_of(controls)));
}

CheckpointWriter::~CheckpointWriter() {
  if (rank(comm_) != 0)
    return;
  out_ = Hdf5Handle(H5I_INVALID_HID, H5Fclose);
  std::error_code ignored; // after commit() it has been moved
  std::filesystem::remove(part_, ignored);
}

template <class Sequence>
void CheckpointWriter::put(const std::string& name, hid_t stored, const Sequence& values) {
  if (!out_ || !failure_.empty())
    return;
  using T = typename Sequence::value_type;
  errno = 0;
  const Hdf5Handle table = make_table(out_, name, stored, 1, values.size(), sizeof(T));
  if (!table || (!values.empty() &&
                 H5Dwrite(table, native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0))
    failure_ = hdf5_failure("HDF5 failed at " + name);
}

void CheckpointWriter::operator()(const std::string& name, double value) {
  put(name, H5T_IEEE_F64LE, std::vector{value});
}

void CheckpointWriter::operator()(const std::string& name, const std::vector<double>& values) {
  put(name, H5T_IEEE_F64LE, values);
}

void CheckpointWriter::operator()(const std::string& name, const std::string& text) {
  put(name, H5T_STD_U8LE, text);
}

void CheckpointWriter::operator()(const std::string& name, const std::shared_ptr<const control::Control>& u) {
  write(name, *u);
}

void CheckpointWriter::operator()(const std::string& name, const control::CompactControl& u) {
  write(name, control::Control(u));
}

void CheckpointWriter::write(const std::string& name, const control::Control& u) {
  const auto columns = static_cast<hsize_t>(starts_.back() + counts_.back());
  Hdf5Handle table(H5I_INVALID_HID, H5Dclose);
  if (out_ && failure_.empty())
    table = make_table(out_, name, H5T_IEEE_F64LE, static_cast<hsize_t>(u.count()), columns, sizeof(double));
  std::vector<double> row(rank(comm_) == 0 ? columns : 0); // collective, even if rank 0 cannot write
  for (int k = 1; k <= u.count(); ++k) {
    const std::span<const double> values = u.at(k);
    MPI_Gatherv(values.data(), static_cast<int>(values.size()), MPI_DOUBLE, row.data(), counts_.data(),
                starts_.data(), MPI_DOUBLE, 0, comm_);
    if (!out_ || !failure_.empty())
      continue;
    errno = 0;
    if (!write_row(table, static_cast<std::size_t>(k) - 1, row))
      failure_ = hdf5_failure("HDF5 failed at " + name);
  }
}

std::string CheckpointWriter::commit() {
  if (rank(comm_) == 0) {
    errno = 0;
    const bool flushed = !out_ || H5Fflush(out_, H5F_SCOPE_GLOBAL) >= 0, closed = out_.finish();
    if (!(flushed && closed) && failure_.empty())
      failure_ = hdf5_failure("HDF5 cannot flush it");
    try {
      if (failure_.empty()) {
        synchronise(part_);
        std::filesystem::rename(part_, file_);
        synchronise(file_.parent_path());
      }
    } catch (const std::filesystem::filesystem_error& error) {
      failure_ = error.code().message();
    }
  }
  return broadcast(comm_, failure_);
}

namespace {

/// Reads an entry of a file; empty if the file or the entry is missing or damaged. Collective.
template <class Sequence>
Sequence read_if_there(MPI_Comm comm, const std::filesystem::path& file, const std::string& name) {
  Sequence values;
  if (rank(comm) == 0) {
    const Hdf5Handle in = open_hdf5(file);
    const Hdf5Handle table(in ? H5Dopen(in, name.c_str(), H5P_DEFAULT) : H5I_INVALID_HID, H5Dclose);
    if (!table || !read_whole(table, values))
      values.clear();
  }
  return broadcast(comm, values);
}

} // namespace

std::string checkpoint_text(MPI_Comm comm, const std::filesystem::path& file, const std::string& name) {
  return read_if_there<std::string>(comm, file, name);
}

std::vector<double> checkpoint_numbers(MPI_Comm comm, const std::filesystem::path& file,
                                       const std::string& name) {
  return read_if_there<std::vector<double>>(comm, file, name);
}

CheckpointReader::CheckpointReader(const control::ControlSpace& controls, const std::filesystem::path& file,
                                   std::string reason)
    : CheckpointReader(controls.space().comm(), file, std::move(reason)) {
  controls_ = &controls;
}

CheckpointReader::CheckpointReader(MPI_Comm comm, const std::filesystem::path& file, std::string reason)
    : comm_(comm), file_(file), reason_(std::move(reason)), in_(H5I_INVALID_HID, H5Fclose) {
  on_root(comm_, [&] {
    in_ = open_hdf5(file);
    if (!in_)
      fail("the file is damaged, or not a checkpoint; use an undamaged file");
  });
}

void CheckpointReader::fail(const std::string& problem) const {
  throw UserError(fmt::format("{}: {}: {}", reason_, file_.string(), problem));
}

void CheckpointReader::damaged(const std::string& name) const {
  fail(fmt::format("\"{}\" is damaged or missing; use an undamaged checkpoint", name));
}

template <class Sequence>
void CheckpointReader::read_entry(const std::string& name, Sequence& values) {
  on_root(comm_, [&] {
    const Hdf5Handle table(H5Dopen(in_, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!table || shape(table)[0] != 1 || !read_whole(table, values))
      damaged(name);
  });
  values = broadcast(comm_, values);
}

void CheckpointReader::operator()(const std::string& name, std::vector<double>& values) {
  read_entry(name, values);
}

void CheckpointReader::operator()(const std::string& name, std::string& text) { read_entry(name, text); }

void CheckpointReader::operator()(const std::string& name, double& value) {
  std::vector<double> values;
  (*this)(name, values);
  if (values.size() != 1)
    damaged(name);
  value = values.front();
}

void CheckpointReader::operator()(const std::string& name, int& value) {
  double number = 0;
  (*this)(name, number);
  if (!(std::abs(number) <= std::numeric_limits<int>::max()))
    damaged(name);
  value = static_cast<int>(number);
}

void CheckpointReader::operator()(const std::string& name, bool& value) {
  int number = 0;
  (*this)(name, number);
  value = number != 0;
}

void CheckpointReader::match_places() {
  const fem::Space& space = controls_->space();
  std::vector<double> padded;
  (*this)(points_name, padded);
  long places = static_cast<long>(controls_->points().size() / 3);
  MPI_Allreduce(MPI_IN_PLACE, &places, 1, MPI_LONG, MPI_SUM, space.comm());
  if (padded.size() != 3 * static_cast<std::size_t>(places))
    fail(fmt::format(
        "found a control at {} points, but this scene's control has {}; use the mesh of the run that wrote "
        "the checkpoint",
        padded.size() / 3, places));
  columns_ = padded.size() / 3 * controls_->components().size();
  std::vector<double> points;
  const auto dim = static_cast<std::size_t>(space.dim());
  for (std::size_t i = 0; i < padded.size(); ++i)
    if (i % 3 < dim)
      points.push_back(padded[i]);
  place_in_file_ = match_points(space, points, places_of(*controls_),
                                [this](const std::string& problem) { fail(problem); });
}

bool CheckpointReader::has(const std::string& name) const {
  int there = rank(comm_) == 0 && H5Lexists(in_, name.c_str(), H5P_DEFAULT) > 0;
  MPI_Bcast(&there, 1, MPI_INT, 0, comm_);
  return there != 0;
}

bool CheckpointReader::matches_places() {
  try {
    match_places();
    return true;
  } catch (const UserError&) {
    return false;
  }
}

control::Control CheckpointReader::control(const std::string& name) {
  return control(name, [&](int k, int rows) {
    if (rows != controls_->count())
      damaged(name);
    return k - 1;
  });
}

void CheckpointReader::operator()(const std::string& name, std::shared_ptr<const control::Control>& u) {
  u = std::make_shared<const control::Control>(control(name));
}

void CheckpointReader::operator()(const std::string& name, control::CompactControl& u) {
  u = control::CompactControl(control(name));
}

control::Control CheckpointReader::control(const std::string& name,
                                           const std::function<int(int k, int rows)>& row_of) {
  control::Control read = controls_->zero();
  Hdf5Handle table(H5I_INVALID_HID, H5Dclose);
  int rows = 0;
  on_root(comm_, [&] {
    table = Hdf5Handle(H5Dopen(in_, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!table || shape(table)[0] == 0 || shape(table)[1] != columns_)
      damaged(name);
    rows = static_cast<int>(shape(table)[0]);
  });
  MPI_Bcast(&rows, 1, MPI_INT, 0, comm_);
  const std::size_t components = controls_->components().size();
  std::vector<double> row(columns_);
  for (int k = 1; k <= read.count(); ++k) {
    const auto from = static_cast<std::size_t>(row_of(k, rows));
    on_root(comm_, [&] {
      if (!read_row(table, from, row) || !std::ranges::all_of(row, [](double x) { return std::isfinite(x); }))
        damaged(name);
    });
    MPI_Bcast(row.data(), static_cast<int>(row.size()), MPI_DOUBLE, 0, comm_);
    const std::span<double> values = read.at(k);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = row[place_in_file_[i / components] * components + i % components];
  }
  return read;
}

} // namespace signorini::io
