// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/vtkhdf.h"
#include <algorithm>
#include <array>
#include <cstring>
#include <fmt/format.h>
#include <functional>
#include <numeric>

namespace signorini::io {

namespace {

constexpr const char* root = "VTKHDF";

template <class T>
bool write_list(hid_t place, const char* name, const std::vector<T>& values) {
  return write_whole(place, name, {values.size()}, values.data(), plain_layout());
}

bool set_attribute(hid_t place, const char* name, hid_t stored, hid_t space, hid_t given, const void* value) {
  Hdf5Handle attribute(H5Acreate(place, name, stored, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const bool written = attribute && H5Awrite(attribute, given, value) >= 0;
  return attribute.finish() && written;
}

/// VTK's number of a kind of cell by its vertices.
std::uint8_t cell_type(std::size_t vertices) {
  constexpr std::uint8_t line = 3, triangle = 5, tetrahedron = 10;
  return vertices == 2 ? line : vertices == 3 ? triangle : tetrahedron;
}

/// Number of all entries of an array of this shape.
hsize_t entries(const std::vector<hsize_t>& shape) {
  return std::accumulate(shape.begin(), shape.end(), hsize_t(1), std::multiplies<>());
}

} // namespace

std::string numbered(std::size_t number) { return fmt::format("{:08}", number); }

bool VtkhdfGroup::create(hid_t file) {
  group_ = make_group(file, root);
  constexpr const char* kind = "UnstructuredGrid";
  constexpr std::array<std::int64_t, 2> version{2, 0};
  constexpr hsize_t two = 2;
  const Hdf5Handle pair(H5Screate_simple(1, &two, nullptr), H5Sclose),
      scalar(H5Screate(H5S_SCALAR), H5Sclose), text(H5Tcopy(H5T_C_S1), H5Tclose);
  return group_ && H5Tset_size(text, std::strlen(kind)) >= 0 && // ASCII of fixed length, else VTK refuses it
         H5Tset_strpad(text, H5T_STR_NULLPAD) >= 0 &&
         set_attribute(group_, "Type", text, scalar, text, kind) &&
         set_attribute(group_, "Version", H5T_STD_I64LE, pair, H5T_NATIVE_INT64, version.data());
}

bool VtkhdfGroup::write_meshes(const std::vector<Part>& parts, std::size_t dim,
                               std::span<const double> points, std::size_t vertices,
                               std::span<const std::int64_t> cells) {
  constexpr std::size_t padded = 3;
  std::vector<double> in_space(points.size() / dim * padded);
  for (std::size_t i = 0; i < points.size(); ++i)
    in_space[i / dim * padded + i % dim] = points[i];
  std::vector<std::int64_t> point_counts, cell_counts, entry_counts, offsets;
  for (const Part& part : parts) {
    point_counts.push_back(static_cast<std::int64_t>(part.points));
    cell_counts.push_back(static_cast<std::int64_t>(part.cells));
    entry_counts.push_back(static_cast<std::int64_t>(part.cells * vertices));
    for (std::size_t cell = 0; cell <= part.cells; ++cell)
      offsets.push_back(static_cast<std::int64_t>(cell * vertices));
  }
  vertices_ = vertices;
  const std::string types(cells.size() / vertices, static_cast<char>(cell_type(vertices)));
  return write_whole(group_, "Points", {points.size() / dim, padded}, in_space.data(), plain_layout()) &&
         write_whole(group_, "Connectivity", {cells.size()}, cells.data(), plain_layout()) &&
         write_whole(group_, "Types", {types.size()}, types.data(), plain_layout()) &&
         write_list(group_, "Offsets", offsets) && write_list(group_, "NumberOfPoints", point_counts) &&
         write_list(group_, "NumberOfCells", cell_counts) &&
         write_list(group_, "NumberOfConnectivityIds", entry_counts);
}

bool VtkhdfGroup::write_cell_numbers(const char* name, std::span<const std::int64_t> numbers) {
  const Hdf5Handle data = make_group(group_, "CellData");
  numbers_.emplace_back(name);
  return data && write_whole(data, name, {numbers.size()}, numbers.data(), plain_layout());
}

bool VtkhdfGroup::write_view(const View& field, std::size_t times) {
  const char* place = field.in_cells ? "CellData" : "PointData";
  const Hdf5Handle data = H5Lexists(group_, place, H5P_DEFAULT) > 0
                              ? Hdf5Handle(H5Gopen(group_, place, H5P_DEFAULT), H5Gclose)
                              : make_group(group_, place);
  const hsize_t rows = field.shape.front(), components = entries(field.shape) / std::max<hsize_t>(rows, 1);
  std::vector<hsize_t> all{times * rows};
  if (components > 1)
    all.push_back(components);
  const auto rank = static_cast<int>(all.size());
  const Hdf5Handle layout = plain_layout(), space(H5Screate_simple(rank, all.data(), nullptr), H5Sclose),
                   part(H5Screate_simple(static_cast<int>(field.shape.size()), field.shape.data(), nullptr),
                        H5Sclose);
  const std::array<hsize_t, 2> count{rows, components};
  bool good = data && space && part;
  for (std::size_t i = 0; good && i < times; ++i) {
    const std::array<hsize_t, 2> first{i * rows, 0};
    const std::string source = field.group + "/" + numbered(i);
    good = H5Sselect_hyperslab(space, H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr) >= 0 &&
           H5Pset_virtual(layout, space, ".", source.c_str(), part) >= 0;
  }
  if (!good)
    return false;
  Hdf5Handle view(
      H5Dcreate(data, field.name.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, layout, H5P_DEFAULT), H5Dclose);
  return view && view.finish();
}

bool VtkhdfGroup::write_times(std::span<const Time> times, const std::vector<View>& fields) {
  const Hdf5Handle steps = make_group(group_, "Steps"), scalar(H5Screate(H5S_SCALAR), H5Sclose);
  const auto count = static_cast<std::int64_t>(times.size());
  bool good = steps && set_attribute(steps, "NSteps", H5T_STD_I64LE, scalar, H5T_NATIVE_INT64, &count);
  std::vector<double> values;
  for (const Time& one : times)
    values.push_back(one.time);
  good = good && write_list(steps, "Values", values);
  // A table's shape is (times × 1) where a time could have several kinds of cells.
  const auto put = [&](hid_t place, const char* name, int rank, auto&& number) {
    std::vector<std::int64_t> column;
    for (const Time& one : times)
      column.push_back(static_cast<std::int64_t>(number(one)));
    std::vector<hsize_t> shape(static_cast<std::size_t>(rank), 1);
    shape.front() = column.size();
    good = good && write_whole(place, name, shape, column.data(), plain_layout());
  };
  put(steps, "NumberOfParts", 1, [](const Time&) { return 1; });
  put(steps, "PartOffsets", 1, [](const Time& one) { return one.part; });
  put(steps, "PointOffsets", 1, [](const Time& one) { return one.first_point; });
  put(steps, "CellOffsets", 2, [](const Time& one) { return one.first_cell; });
  put(steps, "ConnectivityIdOffsets", 2, [&](const Time& one) { return one.first_cell * vertices_; });
  const Hdf5Handle at_points = make_group(steps, "PointDataOffsets"),
                   in_cells = make_group(steps, "CellDataOffsets");
  good = good && at_points && in_cells;
  for (const std::string& name : numbers_)
    put(in_cells, name.c_str(), 1, [](const Time& one) { return one.first_cell; });
  for (const View& field : fields) {
    std::size_t first = 0;
    put(field.in_cells ? in_cells : at_points, field.name.c_str(), 1,
        [&](const Time&) { return field.shape.front() * first++; });
    good = good && write_view(field, times.size());
  }
  return good;
}

bool write_vtkhdf_link(const std::filesystem::path& file, const std::string& target) {
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  Hdf5Handle link = create_hdf5(file, H5F_ACC_TRUNC, access);
  const std::string group = std::string("/") + root;
  const bool linked =
      link && H5Lcreate_external(target.c_str(), group.c_str(), link, root, H5P_DEFAULT, H5P_DEFAULT) >= 0;
  return link.finish() && linked;
}

} // namespace signorini::io
