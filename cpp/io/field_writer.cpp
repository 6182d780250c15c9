// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/field_writer.h"
#include "base/collective.h"
#include "base/dolfinx_versions.h"
#include <algorithm>
#include <array>
#include <cerrno>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/la/Vector.h>
#include <dolfinx/mesh/Mesh.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace signorini::io {

namespace {

constexpr std::size_t padded = 3; // readers of XDMF expect vectors in space

/// Calls `visit(node, geometry)` for each vertex of a cell, with the vertex's local number as a node of V and
/// as a node of the mesh's geometry.
template <class Visit>
void for_vertices(const fem::Space& space, std::int32_t cell, Visit&& visit) {
  const auto mesh = space.mesh().dolfinx();
  const auto geometry = dolfinx_versions::cell_nodes(mesh->geometry());
  const auto nodes = space.dolfinx()->dofmap()->cell_dofs(cell);
  for (std::size_t i = 0; i < geometry.extent(1); ++i) // the nodes at vertices are the first, of degree 2 too
    visit(static_cast<std::size_t>(nodes[i]),
          static_cast<std::size_t>(geometry(static_cast<std::size_t>(cell), i)));
}

std::int32_t local_cells(const fem::Space& space) {
  const auto map = space.mesh().dolfinx()->topology()->index_map(space.dim());
  return map->size_local() + map->num_ghosts();
}

/// Local numbers of the nodes of V that this rank owns and that are vertices of the mesh, ascending.
std::vector<std::size_t> vertices(const fem::Space& space) {
  std::vector<bool> vertex(static_cast<std::size_t>(space.owned_nodes()));
  for (std::int32_t cell = 0; cell < local_cells(space); ++cell)
    for_vertices(space, cell, [&](std::size_t node, std::size_t) {
      if (node < vertex.size())
        vertex[node] = true;
    });
  std::vector<std::size_t> found;
  for (std::size_t node = 0; node < vertex.size(); ++node)
    if (vertex[node])
      found.push_back(node);
  return found;
}

/// Index of the value of each cell that this rank owns in a function that is constant on each cell.
std::vector<std::size_t> places(const fem::Space& space) {
  const auto constants = fem::cellwise(space.mesh(), {});
  std::vector<std::size_t> found;
  for (const std::int32_t cell : space.mesh().owned_cells())
    found.push_back(static_cast<std::size_t>(constants->dofmap()->cell_dofs(cell)[0]));
  return found;
}

/// Shape of a value in the file. In the plane too, vectors have 3 components and tensors 3 × 3.
std::vector<std::size_t> stored_shape(Values values) {
  switch (values) {
  case Values::nodal:
  case Values::cellwise:
    return {padded};
  case Values::cellwise_tensor:
    return {padded, padded};
  default:
    return {1};
  }
}

/// Number of entries of a value in the file.
std::size_t stored_components(Values values) {
  const std::vector<std::size_t> shape = stored_shape(values);
  return std::accumulate(shape.begin(), shape.end(), std::size_t(1), std::multiplies<>());
}

std::size_t components(Values values, int dim) {
  return values == Values::nodal || values == Values::cellwise ? static_cast<std::size_t>(dim)
                                                               : stored_components(values);
}

} // namespace

bool in_cells(Values values) { return values != Values::nodal && values != Values::nodal_scalar; }

FieldLayout::FieldLayout(const fem::Space& space)
    : space_(space), nodes_(rows_of(vertices(space))), cells_(rows_of(places(space))) {}

FieldLayout::Rows FieldLayout::rows_of(std::vector<std::size_t> own) const {
  Rows rows{.own = std::move(own), .counts = {}, .starts = {}};
  rows.counts = signorini::gather(space_.comm(), std::vector<int>{static_cast<int>(rows.own.size())});
  rows.starts.assign(rows.counts.size(), 0);
  std::partial_sum(rows.counts.begin(), rows.counts.end() - 1, rows.starts.begin() + 1);
  return rows;
}

template <class T>
void FieldLayout::gather(const Rows& rows, std::size_t columns, const std::vector<T>& mine,
                         std::vector<T>& all) const {
  all.resize(rank(space_.comm()) == 0 ? rows.total() * columns : 0);
  MPI_Datatype row = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(static_cast<int>(columns * sizeof(T)), MPI_BYTE, &row);
  MPI_Type_commit(&row);
  MPI_Gatherv(mine.data(), static_cast<int>(rows.own.size()), row, all.data(), rows.counts.data(),
              rows.starts.data(), row, 0, space_.comm());
  MPI_Type_free(&row);
}

std::vector<double> FieldLayout::points() const {
  const auto dim = static_cast<std::size_t>(space_.dim());
  const std::span<const double> x = space_.mesh().dolfinx()->geometry().x();
  std::vector<double> at(static_cast<std::size_t>(space_.owned_nodes()) * dim), mine, all;
  for (std::int32_t cell = 0; cell < local_cells(space_); ++cell)
    for_vertices(space_, cell, [&](std::size_t node, std::size_t geometry) {
      if (dim * node < at.size())
        std::copy_n(&x[3 * geometry], dim, &at[dim * node]);
    });
  for (const std::size_t node : nodes_.own)
    mine.insert(mine.end(), &at[dim * node], &at[dim * node] + dim);
  gather(nodes_, dim, mine, all);
  return all;
}

std::vector<std::int64_t> FieldLayout::topology() const {
  dolfinx::la::Vector<std::int64_t> numbers(space_.dolfinx()->dofmap()->index_map, 1);
  std::int64_t next = nodes_.starts[static_cast<std::size_t>(rank(space_.comm()))];
  for (const std::size_t node : nodes_.own)
    dolfinx_versions::entries(numbers)[node] = next++;
  numbers.scatter_fwd();
  std::vector<std::int64_t> mine, all;
  for (const std::int32_t cell : space_.mesh().owned_cells())
    for_vertices(space_, cell, [&](std::size_t node, std::size_t) { mine.push_back(numbers.array()[node]); });
  gather(cells_, static_cast<std::size_t>(space_.dim()) + 1, mine, all);
  return all;
}

std::span<const double> FieldLayout::gather(Values values, std::span<const double> owned) {
  const Rows& rows = in_cells(values) ? cells_ : nodes_;
  const std::size_t given = components(values, space_.dim()), stored = stored_components(values);
  mine_.resize(rows.own.size() * stored);
  auto next = mine_.begin();
  for (const std::size_t row : rows.own)
    next = std::fill_n(std::copy_n(&owned[given * row], given, next), stored - given, 0.0);
  if (ranks(space_.comm()) == 1)
    return mine_;
  gather(rows, stored, mine_, all_);
  return all_;
}

namespace {

/// Shape of the dataset of a field at one time.
std::vector<hsize_t> dataset_shape(const FieldLayout& layout, Values values) {
  std::vector<hsize_t> shape{layout.rows(values)};
  std::ranges::copy(stored_shape(values), std::back_inserter(shape));
  return shape;
}

const char* attribute_type(Values values) {
  const std::size_t components = stored_components(values);
  return components == 1 ? "Scalar" : components == padded ? "Vector" : "Tensor";
}

// One collection with a grid for each time, which has the mesh and all fields. meshio and the readers of VTK
// and ParaView expect this (those of XDMF 2 resolve no references between grids).
constexpr const char *before_grids = R"xml(<?xml version="1.0"?>
<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>
<Xdmf Version="3.0">
  <Domain>
    <Grid Name="fields" GridType="Collection" CollectionType="Temporal">
)xml",
                     *after_grids = "    </Grid>\n  </Domain>\n</Xdmf>\n";

} // namespace

FieldWriter::FieldWriter(const fem::Space& space, const OutputFolder& folder, const std::string& name,
                         std::vector<FieldSeries> fields, std::size_t times,
                         const std::vector<scene::FieldFormat>& formats)
    : space_(space), folder_(folder), name_(name),
      xdmf_(std::ranges::find(formats, scene::FieldFormat::xdmf) != formats.end()), layout_(space),
      file_(H5I_INVALID_HID, H5Fclose), layout_list_(H5I_INVALID_HID, H5Pclose), fields_(std::move(fields)) {
  data_ = name + (xdmf_ ? ".h5" : ".vtkhdf");
  if (std::ranges::find(formats, scene::FieldFormat::vtkhdf) != formats.end())
    vtkhdf_.emplace();
  for (std::size_t i = 0; i < fields_.size(); ++i)
    datasets_.push_back({Hdf5Handle(H5I_INVALID_HID, H5Gclose)});
  require_room(times);
  const std::vector<double> points = layout_.points();
  const std::vector<std::int64_t> topology = layout_.topology();
  guarded([&] { return open(points, topology); });
}

void FieldWriter::require_room(std::size_t times) const {
  constexpr double headers = 1024; // bytes of a dataset's header, its view and the XDMF text about it
  double needed = 0;
  for (const FieldSeries& field : fields_)
    needed += headers + sizeof(double) *
                            static_cast<double>(layout_.rows(field.values) * stored_components(field.values));
  needed *= static_cast<double>(times);
  const double mesh = static_cast<double>(layout_.nodes() + layout_.cells()) * (space_.dim() + 2);
  needed += sizeof(double) * mesh * (vtkhdf_ ? 2 : 1);
  on_root(space_.comm(), [&] {
    std::error_code unknown;
    const auto room = std::filesystem::space(folder_.path(), unknown);
    if (!unknown && static_cast<double>(room.available) < needed)
      throw OutputFailure(fmt::format(
          "{}: cannot be written (it needs {:.3g} MB, and the disk has {:.3g} MB left)",
          (folder_.path() / data_).string(), needed / 1e6, static_cast<double>(room.available) / 1e6));
  });
}

template <class Work>
void FieldWriter::guarded(Work&& work) {
  on_root(space_.comm(), [&] {
    errno = 0;
    if (!work())
      throw OutputFailure(
          fmt::format("{}: cannot be written ({})", (folder_.path() / data_).string(), hdf5_failure()));
  });
}

bool FieldWriter::open(std::span<const double> points, std::span<const std::int64_t> topology) {
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_sieve_buf_size(access, 0); // datasets are written whole
  // The format of HDF5 1.8 takes half the time for each dataset, and finds its place in a group of thousands.
  // Views need HDF5 1.10.
  H5Pset_libver_bounds(access, H5F_LIBVER_V18, vtkhdf_ ? H5F_LIBVER_V110 : H5F_LIBVER_V18);
  file_ = create_hdf5(folder_.staged(data_), H5F_ACC_TRUNC, access);
  layout_list_ = plain_layout();
  const Hdf5Handle meshes = make_group(file_, "Mesh"), mesh = make_group(meshes, "mesh"),
                   functions = make_group(file_, "Function");
  const auto dim = static_cast<std::size_t>(space_.dim());
  bool good = mesh && functions &&
              write_whole(mesh, "geometry", {layout_.nodes(), dim}, points.data(), layout_list_) &&
              write_whole(mesh, "topology", {layout_.cells(), dim + 1}, topology.data(), layout_list_);
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    datasets_[i].group = make_group(functions, fields_[i].name.c_str());
    good = good && datasets_[i].group;
  }
  return good &&
         (!vtkhdf_ || (vtkhdf_->create(file_) && vtkhdf_->write_meshes({{layout_.nodes(), layout_.cells()}},
                                                                       dim, points, dim + 1, topology)));
}

void FieldWriter::write(const std::string& field, std::size_t number, double time, Vec values) {
  write(field, number, time, petsc::ReadArray(values));
}

void FieldWriter::write(const std::string& field, std::size_t number, double time,
                        std::span<const double> owned) {
  const auto series = std::ranges::find(fields_, field, &FieldSeries::name);
  if (series == fields_.end())
    throw std::logic_error("the file was opened without this field");
  Datasets& datasets = datasets_[static_cast<std::size_t>(series - fields_.begin())];
  const std::span<const double> rows = layout_.gather(series->values, owned);
  guarded([&] {
    return write_whole(datasets.group, numbered(number).c_str(), dataset_shape(layout_, series->values),
                       rows.data(), layout_list_);
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

std::string FieldWriter::grid(std::size_t number) const {
  const int dim = space_.dim();
  std::string text = fmt::format(R"xml(      <Grid Name="mesh" GridType="Uniform">
        <Time Value="{0}" />
        <Topology TopologyType="{1}" NumberOfElements="{2}" NodesPerElement="{3}">
          <DataItem Dimensions="{2} {3}" NumberType="Int" Precision="8" Format="HDF">{4}:/Mesh/mesh/topology</DataItem>
        </Topology>
        <Geometry GeometryType="{5}">
          <DataItem Dimensions="{6} {7}" NumberType="Float" Precision="8" Format="HDF">{4}:/Mesh/mesh/geometry</DataItem>
        </Geometry>
)xml",
                                 times_[number], dim == 3 ? "Tetrahedron" : "Triangle", layout_.cells(),
                                 dim + 1, data_, dim == 3 ? "XYZ" : "XY", layout_.nodes(), dim);
  for (const auto& [name, values] : fields_)
    fmt::format_to(std::back_inserter(text),
                   R"xml(        <Attribute Name="{0}" AttributeType="{1}" Center="{2}">
          <DataItem Dimensions="{3} {4}" NumberType="Float" Precision="8" Format="HDF">{5}:/Function/{0}/{6}</DataItem>
        </Attribute>
)xml",
                   name, attribute_type(values), in_cells(values) ? "Cell" : "Node", layout_.rows(values),
                   fmt::join(stored_shape(values), " "), data_, numbered(number));
  return text + "      </Grid>\n";
}

bool FieldWriter::write_views() {
  std::vector<VtkhdfGroup::Time> times;
  for (const double time : times_)
    times.push_back({.time = time});
  std::vector<VtkhdfGroup::View> views;
  for (const auto& [name, values] : fields_)
    views.push_back({name, "/Function/" + name, in_cells(values), dataset_shape(layout_, values)});
  const bool good = vtkhdf_->write_times(times, views);
  vtkhdf_.reset(); // the file can be closed only without open groups
  return good;
}

void FieldWriter::write_xdmf() const {
  TextFile text(folder_, name_ + ".xdmf");
  text.append(before_grids);
  for (std::size_t i = 0; i < times_.size(); ++i)
    text.append(grid(i));
  text.append(after_grids);
  text.close();
}

void FieldWriter::close() {
  if (std::ranges::any_of(datasets_, [&](const Datasets& one) { return one.written != times_.size(); }))
    throw std::logic_error("the fields of a file have different times");
  const bool linked = xdmf_ && vtkhdf_;
  guarded([&] {
    bool good = write_whole(file_, "times", {times_.size()}, times_.data(), layout_list_);
    good = good && (!vtkhdf_ || write_views());
    for (Datasets& one : datasets_)
      good = one.group.finish() && good;
    good = H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0 && good;
    return file_.finish() && good;
  });
  if (linked)
    guarded([&] { return write_vtkhdf_link(folder_.staged(name_ + ".vtkhdf"), data_); });
  if (xdmf_)
    write_xdmf();
}

} // namespace signorini::io
