#include "io/fields.h"
#include "base/collective.h"
#include <algorithm>
#include <dolfinx/fem/Function.h>
#include <dolfinx/io/XDMFFile.h>
#include <dolfinx/mesh/Mesh.h>
#include <fmt/format.h>

namespace signorini::io {
namespace {

void copy(Vec from, dolfinx::fem::Function<PetscScalar>& to) {
  const petsc::ReadArray values(from);
  std::ranges::copy(std::span<const double>(values), to.x()->mutable_array().begin());
  to.x()->scatter_fwd();
}

} // namespace

void write_fields(const fem::Space& space, const std::filesystem::path& file, const std::vector<double>& times,
                  const std::vector<FieldSeries>& fields) {
  using Function = dolfinx::fem::Function<PetscScalar>;
  try {
    Function own(space.dolfinx()), nodal(space.degree() == 1 ? space.dolfinx() : fem::lagrange(space.mesh(), 1));
    dolfinx::io::XDMFFile xdmf(space.comm(), file, "w");
    xdmf.write_mesh(*space.mesh().dolfinx());
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
        xdmf.write_function(nodal, times[i]);
      }
    }
  } catch (const std::exception& error) {
    throw UserError(fmt::format("{}: cannot be written ({})", file.string(), error.what()));
  }
}

} // namespace signorini::io
