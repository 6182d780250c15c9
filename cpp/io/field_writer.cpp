// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/field_writer.h"
#include "io/output_failure.h"
#include <H5Epublic.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace signorini::io {

namespace {

const char* attribute_type(Values values) {
  switch (values) {
  case Values::nodal:
  case Values::cellwise:
    return "Vector";
  case Values::cellwise_tensor:
    return "Tensor";
  default:
    return "Scalar";
  }
}

} // namespace

std::string numbered(std::size_t number) { return fmt::format("{:08}", number); }

XdmfIndex::XdmfIndex(std::string data, int dim, std::size_t nodes, std::size_t cells)
    : data_(std::move(data)), dim_(dim), nodes_(nodes), cells_(cells) {}

std::string XdmfIndex::begin() {
  return R"xml(<?xml version="1.0"?>
<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>
<Xdmf Version="3.0">
  <Domain>
    <Grid Name="fields" GridType="Collection" CollectionType="Temporal">
)xml";
}

std::string XdmfIndex::time(std::size_t number, double time, std::span<const FieldSeries> fields) const {
  std::string text = fmt::format(R"xml(      <Grid Name="mesh" GridType="Uniform">
        <Time Value="{0}" />
        <Topology TopologyType="{1}" NumberOfElements="{2}" NodesPerElement="{3}">
          <DataItem Dimensions="{2} {3}" NumberType="Int" Precision="8" Format="HDF">{4}:/Mesh/mesh/topology</DataItem>
        </Topology>
        <Geometry GeometryType="{5}">
          <DataItem Dimensions="{6} {7}" NumberType="Float" Precision="8" Format="HDF">{4}:/Mesh/mesh/geometry</DataItem>
        </Geometry>
)xml",
                                 time, dim_ == 3 ? "Tetrahedron" : "Triangle", cells_, dim_ + 1, data_,
                                 dim_ == 3 ? "XYZ" : "XY", nodes_, dim_);
  for (const auto& [name, values] : fields)
    fmt::format_to(
        std::back_inserter(text), R"xml(        <Attribute Name="{0}" AttributeType="{1}" Center="{2}">
          <DataItem Dimensions="{3} {4}" NumberType="Float" Precision="8" Format="HDF">{5}:/Function/{0}/{6}</DataItem>
        </Attribute>
)xml",
        name, attribute_type(values), in_cells(values) ? "Cell" : "Node", in_cells(values) ? cells_ : nodes_,
        fmt::join(stored_shape(values), " "), data_, numbered(number));
  return text + "      </Grid>\n";
}

std::string XdmfIndex::end() { return "    </Grid>\n  </Domain>\n</Xdmf>\n"; }

namespace {

Hdf5Handle create_file(const std::filesystem::path& file) {
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_sieve_buf_size(access, 0); // datasets are written whole
  return {H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose};
}

Hdf5Handle plain_layout() {
  Hdf5Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_fill_time(list, H5D_FILL_TIME_NEVER);
  H5Pset_obj_track_times(list, false); // two equal runs write equal bytes
  return list;
}

Hdf5Handle make_group(hid_t place, const char* name) {
  return {H5Gcreate(place, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose};
}

} // namespace

FieldWriter::FieldWriter(const fem::Space& space, const OutputFolder& folder, const std::string& name,
                         std::vector<FieldSeries> fields, std::size_t times)
    : space_(space), folder_(folder), name_(name),
      data_(std::filesystem::path(name).replace_extension(".h5").string()), layout_(space),
      file_(H5I_INVALID_HID, H5Fclose), layout_list_(H5I_INVALID_HID, H5Pclose), fields_(std::move(fields)) {
  for (std::size_t i = 0; i < fields_.size(); ++i)
    datasets_.push_back({Hdf5Handle(H5I_INVALID_HID, H5Gclose)});
  require_room(times);
  const std::vector<double> points = layout_.points();
  const std::vector<std::int64_t> topology = layout_.topology();
  guarded([&] { return open(points, topology); });
}

void FieldWriter::require_room(std::size_t times) const {
  constexpr double headers = 1024; // bytes of a dataset's header and of the XDMF text about it
  double needed = 0;
  for (const FieldSeries& field : fields_)
    needed += headers + sizeof(double) *
                            static_cast<double>(layout_.rows(field.values) * stored_components(field.values));
  needed *= static_cast<double>(times);
  needed += sizeof(double) * static_cast<double>(layout_.nodes() + layout_.cells()) * (space_.dim() + 1);
  write_on_root(space_.comm(), [&] {
    std::error_code unknown;
    const auto room = std::filesystem::space(folder_.path(), unknown);
    if (!unknown && static_cast<double>(room.available) < needed)
      throw OutputFailure(fmt::format(
          "{}: cannot be written (it needs {:.3g} MB, and the disk has {:.3g} MB left)",
          (folder_.path() / name_).string(), needed / 1e6, static_cast<double>(room.available) / 1e6));
  });
}

template <class Work>
void FieldWriter::guarded(Work&& work) {
  write_on_root(space_.comm(), [&] {
    errno = 0;
    if (!work())
      throw OutputFailure(fmt::format("{}: cannot be written ({})", (folder_.path() / data_).string(),
                                      errno ? std::generic_category().message(errno) : "HDF5 failed"));
  });
}

bool FieldWriter::open(std::span<const double> points, std::span<const std::int64_t> topology) {
  H5Eset_auto(H5E_DEFAULT, nullptr, nullptr); // one sentence is reported instead of HDF5's stack
  file_ = create_file(folder_.staged(data_));
  layout_list_ = plain_layout();
  const Hdf5Handle meshes = make_group(file_, "Mesh"), mesh = make_group(meshes, "mesh"),
                   functions = make_group(file_, "Function");
  const auto dim = static_cast<std::size_t>(space_.dim());
  bool good =
      mesh && functions &&
      put(mesh, "geometry", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {layout_.nodes(), dim}, points.data()) &&
      put(mesh, "topology", H5T_STD_I64LE, H5T_NATIVE_INT64, {layout_.cells(), dim + 1}, topology.data());
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    datasets_[i].group = make_group(functions, fields_[i].name.c_str());
    good = good && datasets_[i].group;
  }
  return good;
}

bool FieldWriter::put(hid_t place, const char* name, hid_t stored, hid_t given,
                      const std::vector<hsize_t>& shape, const void* data) const {
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
  Hdf5Handle set(H5Dcreate(place, name, stored, space, H5P_DEFAULT, layout_list_, H5P_DEFAULT), H5Dclose);
  const bool written = set && H5Dwrite(set, given, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
  return set.finish() && written;
}

void FieldWriter::write(const std::string& field, std::size_t number, double time, Vec values) {
  write(field, number, time, petsc::ReadArray(values));
}

void FieldWriter::write(const std::string& field, std::size_t number, double time,
                        std::span<const double> owned) {
  const auto series = std::ranges::find(fields_, field, &FieldSeries::name);
  if (series == fields_.end())
    throw std::logic_error("a field that the file was not opened for");
  Datasets& datasets = datasets_[static_cast<std::size_t>(series - fields_.begin())];
  const std::span<const double> rows = layout_.gather(series->values, owned);
  std::vector<hsize_t> shape{layout_.rows(series->values)};
  std::ranges::copy(stored_shape(series->values), std::back_inserter(shape));
  guarded([&] {
    return put(datasets.group, numbered(number).c_str(), H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, shape,
               rows.data());
  });
  ++datasets.written;
  times_.resize(std::max(times_.size(), number + 1));
  times_[number] = time;
}

void FieldWriter::make_room(std::size_t number) {
  guarded([&] {
    bool good = true;
    for (const Datasets& one : datasets_)
      for (std::size_t i = times_.size(); good && i-- > number;)
        good = H5Lmove(one.group, numbered(i).c_str(), one.group, numbered(i + 1).c_str(), H5P_DEFAULT,
                       H5P_DEFAULT) >= 0;
    return good;
  });
  times_.insert(times_.begin() + static_cast<std::ptrdiff_t>(number), 0);
}

void FieldWriter::close() {
  if (std::ranges::any_of(datasets_, [&](const Datasets& one) { return one.written != times_.size(); }))
    throw std::logic_error("the fields of a file have different times");
  guarded([&] {
    bool good = put(file_, "times", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {times_.size()}, times_.data());
    for (Datasets& one : datasets_)
      good = one.group.finish() && good;
    good = H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0 && good;
    return file_.finish() && good;
  });
  const XdmfIndex index(data_, space_.dim(), layout_.nodes(), layout_.cells());
  TextFile text(folder_, name_);
  text.append(XdmfIndex::begin());
  for (std::size_t i = 0; i < times_.size(); ++i)
    text.append(index.time(i, times_[i], fields_));
  text.append(XdmfIndex::end());
  text.close();
}

} // namespace signorini::io
