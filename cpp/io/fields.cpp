#include "io/fields.h"
#include "base/collective.h"
#include "base/hdf5.h"
#include "fem/function.h"
#include <H5Epublic.h>
#include <algorithm>
#include <cerrno>
#include <dolfinx/io/XDMFFile.h>
#include <dolfinx/mesh/Mesh.h>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <memory>
#include <numeric>
#include <optional>
#include <pugixml.hpp>
#include <stdexcept>
#include <system_error>

namespace signorini::io {
namespace {

using Values = FieldFile::Values;

bool cellwise(Values values) { return values != Values::nodal && values != Values::nodal_scalar; }

/// The components of a value.
fem::Shape shape(Values values, int dim) {
  switch (values) {
  case Values::nodal:
  case Values::cellwise:
    return {static_cast<std::size_t>(dim)};
  case Values::cellwise_tensor:
    return {3, 3};
  default:
    return {};
  }
}

/// A parallel write to a full disk hangs in some MPI libraries: check the free space beforehand.
void require_room(const fem::Space& space, const OutputFolder& folder, const std::string& name,
                  std::size_t datasets) {
  const double values = static_cast<double>( // nodes or cells, whichever are more
      std::max(space.mesh().dolfinx()->geometry().index_map()->size_global(), space.mesh().cells()));
  constexpr double overhead = 8192,
                   mesh_share = 8; // bytes of headers and XML per dataset; mesh in units of a field
  const double field = 3 * sizeof(double) * values;
  const double needed = static_cast<double>(datasets) * (field + overhead) + mesh_share * field;
  on_root(space.comm(), [&] {
    std::error_code unknown;
    const auto room = std::filesystem::space(folder.path(), unknown);
    if (!unknown && static_cast<double>(room.available) < needed)
      throw UserError(fmt::format(
          "{}: cannot be written (it needs {:.3g} MB, and the disk has {:.3g} MB left)",
          (folder.path() / name).string(), needed / 1e6, static_cast<double>(room.available) / 1e6));
  });
}

/// Whether an XDMF file has its end and all times: dolfinx does not check its writes. A lost stream buffer is
/// longer than the text of one time, so that some of them would be missing.
bool whole(const std::filesystem::path& file, std::size_t times) {
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  std::size_t found = 0;
  for (std::size_t at = text.find("<Time "); at != std::string::npos; at = text.find("<Time ", at + 1))
    ++found;
  return found == times && text.ends_with("</Xdmf>\n");
}

/// The datasets of a field in ascending order of time, as the writer calls them.
struct Order {
  std::string field;
  std::vector<std::string> names;
};

/// The name of a dataset by its number in the order of time.
std::string numbered(std::size_t number) { return fmt::format("{:08}", number); }

/// Sorts the grids of a field by their times, which are in the order of the grids, and lets them refer to the
/// datasets by numbers. Returns the datasets' names so far; fewer if the file lacks some.
std::vector<std::string> number_grids(pugi::xml_node series, const std::vector<double>& times) {
  std::vector<std::pair<double, pugi::xml_node>> grids;
  for (pugi::xml_node grid : series.children("Grid"))
    grids.emplace_back(grids.size() < times.size() ? times[grids.size()] : 0, grid);
  std::ranges::stable_sort(grids, {}, &std::pair<double, pugi::xml_node>::first);
  std::vector<std::string> names;
  for (const auto& [time, grid] : grids) {
    series.append_move(grid);
    pugi::xml_text place = grid.child("Attribute").child("DataItem").text(); // state.h5:/Function/y/0_25
    const std::string path = place.get();
    const std::size_t name = path.rfind('/') + 1;
    place.set((path.substr(0, name) + numbered(names.size())).c_str());
    names.push_back(path.substr(name));
  }
  return names;
}

/// Gives the datasets of all fields their numbers as names, and adds the times. Returns false if that fails.
bool rename_datasets(const std::filesystem::path& file, const std::vector<Order>& orders,
                     const std::vector<double>& times) {
  Opened data(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  bool good = static_cast<bool>(data);
  const auto move = [&](const std::string& from, const std::string& to) {
    good = good && H5Lmove(data, from.c_str(), data, to.c_str(), H5P_DEFAULT, H5P_DEFAULT) >= 0;
  };
  const std::string before = "/unordered"; // no dataset has the name that another one is to have
  for (const Order& order : orders) {
    const std::string group = "/Function/" + order.field;
    move(group, before);
    good = good && Opened(H5Gcreate(data, group.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    for (std::size_t i = 0; i < order.names.size(); ++i)
      move(before + "/" + order.names[i], group + "/" + numbered(i));
    good = good && H5Ldelete(data, before.c_str(), H5P_DEFAULT) >= 0;
  }
  const hsize_t count = times.size();
  const Opened space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  Opened array(good ? H5Dcreate(data, "/times", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)
                    : H5I_INVALID_HID,
               H5Dclose);
  good = array && H5Dwrite(array, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, times.data()) >= 0;
  good = array.finish() && good;
  good = good && H5Fflush(data, H5F_SCOPE_GLOBAL) >= 0;
  return data.finish() && good;
}

} // namespace

struct FieldFile::Open {
  dolfinx::io::XDMFFile xdmf;

  /// Functions of one kind of values.
  struct Kind {
    fem::Function written;            ///< in the file's space
    std::optional<fem::Function> own; ///< in the run's, where that is another
  };
  std::map<Values, Kind> kinds;

  Kind& of(Values values, const fem::Space& space) {
    if (const auto found = kinds.find(values); found != kinds.end())
      return found->second;
    const fem::Shape components = shape(values, space.dim());
    if (cellwise(values))
      return kinds.try_emplace(values, Kind{fem::Function(fem::cellwise(space.mesh(), components)), {}})
          .first->second;
    const auto V =
        values == Values::nodal ? space.dolfinx() : fem::lagrange(space.mesh(), space.degree(), components);
    Kind made{fem::Function(space.degree() == 1 ? V : fem::lagrange(space.mesh(), 1, components)), {}};
    if (space.degree() > 1)
      made.own.emplace(V);
    return kinds.emplace(values, std::move(made)).first->second;
  }
};

FieldFile::FieldFile(const fem::Space& space, const OutputFolder& folder, const std::string& name,
                     std::size_t fields, Values values)
    : space_(space), folder_(folder), name_(name), values_(values) {
  require_room(space, folder, name, fields);
  H5Eset_auto(H5E_DEFAULT, nullptr, nullptr); // one sentence is reported instead of HDF5's stack
  guarded([&] {
    open_.reset(new Open{dolfinx::io::XDMFFile(space.comm(), folder.staged(name), "w"), {}});
    open_->xdmf.write_mesh(*space.mesh().dolfinx());
  });
}

FieldFile::~FieldFile() {
  if (!open_)
    return;
  if (ranks(space_.comm()) > 1) {
    (void)open_.release();
    return;
  }
  try {
    open_->xdmf.close();
  } catch (const std::exception&) { // its destructor would throw again and end the program
    (void)open_.release();
  }
}

template <class Work>
void FieldFile::guarded(Work&& work) {
  errno = 0;
  try {
    work();
  } catch (const std::exception& error) {
    const std::string reason = errno != 0 ? std::generic_category().message(errno) : error.what();
    (void)open_.release(); // its destructor would throw again and end the program
    folder_.discard();
    throw WriteFailure(fmt::format("{}: cannot be written ({})", (folder_.path() / name_).string(), reason));
  }
}

void FieldFile::write(const std::string& field, Vec values, double time) {
  write(field, petsc::ReadArray(values), time, values_);
}

void FieldFile::write(const std::string& field, std::span<const double> owned, double time, Values values) {
  guarded([&] {
    auto& [written, own] = open_->of(values, space_);
    fem::set(own ? *own : written, owned);
    if (own) {
      written.interpolate(*own);
      written.x()->scatter_fwd();
    }
    written.name = field;
    open_->xdmf.write_function(written, time);
    times_[field].push_back(time);
  });
}

void FieldFile::close() {
  guarded([&] { open_->xdmf.close(); });
  open_.reset();
  on_root(space_.comm(), [&] {
    put_in_order();
    std::size_t all = 0;
    for (const auto& [field, times] : times_)
      all += times.size();
    if (!whole(folder_.staged(name_), all))
      throw UserError(
          fmt::format("{}: cannot be written (a part of it is missing)", (folder_.path() / name_).string()));
  });
}

void FieldFile::put_in_order() const {
  const std::filesystem::path file = folder_.staged(name_);
  const auto fail = [&](const std::string& name, const std::string& why) {
    throw UserError(fmt::format("{}: cannot be written ({})", (folder_.path() / name).string(), why));
  };
  constexpr unsigned everything = pugi::parse_default | pugi::parse_doctype | pugi::parse_declaration;
  pugi::xml_document document;
  if (const pugi::xml_parse_result read = document.load_file(file.c_str(), everything); !read)
    fail(name_, fmt::format("its times cannot be put in order: {}", read.description()));
  std::vector<double> ascending;
  std::vector<Order> orders;
  for (pugi::xml_node series : document.child("Xdmf").child("Domain").children("Grid")) {
    if (series.attribute("GridType").value() != std::string("Collection"))
      continue;
    const std::string field = series.attribute("Name").value();
    const std::vector<double>& times = times_.at(field);
    orders.push_back({field, number_grids(series, times)});
    std::vector<double> sorted = times;
    std::ranges::sort(sorted);
    if (orders.size() > 1 && sorted != ascending)
      throw std::logic_error("the fields of a file have different times");
    ascending = std::move(sorted);
  }
  errno = 0;
  if (!document.save_file(file.c_str(), "  ")) // as dolfinx does
    fail(name_, std::generic_category().message(errno));
  errno = 0;
  const std::filesystem::path data = std::filesystem::path(name_).replace_extension(".h5");
  if (!rename_datasets(folder_.staged(data), orders, ascending))
    fail(data, errno ? std::generic_category().message(errno) : "HDF5 cannot name its datasets");
}

} // namespace signorini::io
