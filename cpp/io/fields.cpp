#include "io/fields.h"
#include "base/collective.h"
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
#include <optional>
#include <pugixml.hpp>
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
    const auto [last, first] = last_.try_emplace(field, time);
    sorted_ = sorted_ && (first || last->second < time);
    last->second = time;
    written.name = field;
    open_->xdmf.write_function(written, time);
    ++times_;
  });
}

void FieldFile::close() {
  guarded([&] { open_->xdmf.close(); });
  open_.reset();
  on_root(space_.comm(), [&] {
    if (!sorted_)
      sort_times();
    if (!whole(folder_.staged(name_), times_))
      throw UserError(
          fmt::format("{}: cannot be written (a part of it is missing)", (folder_.path() / name_).string()));
  });
}

void FieldFile::sort_times() const {
  const std::string file = folder_.staged(name_);
  constexpr unsigned everything = pugi::parse_default | pugi::parse_doctype | pugi::parse_declaration;
  pugi::xml_document document;
  if (const pugi::xml_parse_result read = document.load_file(file.c_str(), everything); !read)
    throw UserError(fmt::format("{}: cannot be written (its times cannot be put in order: {})",
                                (folder_.path() / name_).string(), read.description()));
  for (pugi::xml_node series : document.child("Xdmf").child("Domain").children("Grid")) {
    if (series.attribute("GridType").value() != std::string("Collection"))
      continue;
    std::vector<std::pair<double, pugi::xml_node>> grids;
    for (pugi::xml_node grid : series.children("Grid"))
      grids.emplace_back(grid.child("Time").attribute("Value").as_double(), grid);
    std::ranges::stable_sort(grids, {}, &std::pair<double, pugi::xml_node>::first);
    for (const auto& [time, grid] : grids)
      series.append_move(grid);
  }
  errno = 0;
  if (!document.save_file(file.c_str(), "  ")) // as dolfinx does
    throw UserError(fmt::format("{}: cannot be written ({})", (folder_.path() / name_).string(),
                                std::generic_category().message(errno)));
}

} // namespace signorini::io
