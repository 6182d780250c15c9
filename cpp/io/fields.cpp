#include "io/fields.h"
#include "base/collective.h"
#include <H5Epublic.h>
#include <algorithm>
#include <cerrno>
#include <dolfinx/fem/Function.h>
#include <dolfinx/io/XDMFFile.h>
#include <dolfinx/mesh/Mesh.h>
#include <fmt/format.h>
#include <memory>
#include <system_error>

namespace signorini::io {
namespace {

void copy(Vec from, dolfinx::fem::Function<PetscScalar>& to) {
  const petsc::ReadArray values(from);
  std::ranges::copy(std::span<const double>(values), to.x()->mutable_array().begin());
  to.x()->scatter_fwd();
}

/// A parallel write to a full disk hangs in some MPI libraries, so the room is looked at before.
void require_room(const fem::Space& space, const OutputFolder& folder, const std::string& name, std::size_t datasets) {
  const auto map = space.mesh().dolfinx()->geometry().index_map();
  constexpr double overhead = 8192, mesh_share = 8; // bytes of headers and XML per dataset; mesh in units of a field
  const double field = 3 * sizeof(double) * static_cast<double>(map->size_global());
  const double needed = static_cast<double>(datasets) * (field + overhead) + mesh_share * field;
  on_root(space.comm(), [&] {
    std::error_code unknown;
    const auto room = std::filesystem::space(folder.path(), unknown);
    if (!unknown && static_cast<double>(room.available) < needed)
      throw UserError(fmt::format("{}: cannot be written (it needs {:.3g} MB, and the disk has {:.3g} MB left)",
                                  (folder.path() / name).string(), needed / 1e6,
                                  static_cast<double>(room.available) / 1e6));
  });
}

} // namespace

void write_fields(const fem::Space& space, const OutputFolder& folder, const std::string& name,
                  const std::vector<double>& times, const std::vector<FieldSeries>& fields) {
  using Function = dolfinx::fem::Function<PetscScalar>;
  require_room(space, folder, name, times.size() * fields.size());
  H5Eset_auto(H5E_DEFAULT, nullptr, nullptr); // one sentence below says it, instead of HDF5's stack
  std::unique_ptr<dolfinx::io::XDMFFile> xdmf;
  errno = 0;
  try {
    Function own(space.dolfinx()), nodal(space.degree() == 1 ? space.dolfinx() : fem::lagrange(space.mesh(), 1));
    xdmf = std::make_unique<dolfinx::io::XDMFFile>(space.comm(), folder.staged(name), "w");
    xdmf->write_mesh(*space.mesh().dolfinx());
    for (const FieldSeries& field : fields) {
      nodal.name = field.name;
      for (std::size_t i = 0; i < times.size(); ++i) {
        if (space.degree() == 1) {
          copy(field.values[i], nodal);
        } else {
          copy(field.values[i], own);
          nodal.interpolate(own);
          nodal.x()->scatter_fwd();
        }
        xdmf->write_function(nodal, times[i]);
      }
    }
    xdmf->close();
  } catch (const std::exception& error) {
    const std::string reason = errno != 0 ? std::generic_category().message(errno) : error.what();
    (void)xdmf.release(); // its destructor would throw the same error again, and end the program
    folder.discard();
    throw WriteFailure(fmt::format("{}: cannot be written ({})", (folder.path() / name).string(), reason));
  }
}

} // namespace signorini::io
