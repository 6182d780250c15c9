// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/deformation.h"
#include "base/collective.h"
#include "base/dolfinx_versions.h"
#include "mesh/simplex.h"
#include <algorithm>
#include <basix/cell.h>
#include <cmath>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/la/Vector.h>
#include <dolfinx/mesh/Mesh.h>
#include <numbers>
#include <span>

namespace signorini::fem {
using mesh::Simplex;

namespace {

using Gradient = std::array<std::array<double, 3>, 3>; // ∂y_r/∂x_c

/// Determinant of the (3 × 3) matrix with the entries f(i, j).
template <class Entry>
double determinant(Entry&& f) {
  return f(0, 0) * (f(1, 1) * f(2, 2) - f(1, 2) * f(2, 1)) -
         f(0, 1) * (f(1, 0) * f(2, 2) - f(1, 2) * f(2, 0)) +
         f(0, 2) * (f(1, 0) * f(2, 1) - f(1, 1) * f(2, 0));
}

/// Largest modulus of the eigenvalues of the symmetric part of G, by the trigonometric formula. Returns 0
/// without computing it if a bound shows that it is less than `least`.
double principal_strain(const Gradient& G, double least) {
  const auto e = [&](int i, int j) { return (G[i][j] + G[j][i]) / 2; };
  const double mean = (e(0, 0) + e(1, 1) + e(2, 2)) / 3;
  double square = 0; // squared norm of the deviator
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      square += std::pow(e(i, j) - (i == j ? mean : 0), 2);
  const double p = std::sqrt(square / 6);
  if (p == 0)
    return std::abs(mean);
  if (std::abs(mean) + 2 * p < least)
    return 0;
  const double third = determinant([&](int i, int j) { return (e(i, j) - (i == j ? mean : 0)) / p; });
  const double angle = std::acos(std::clamp(third / 2, -1.0, 1.0)) / 3;
  const double high = mean + 2 * p * std::cos(angle),
               low = mean + 2 * p * std::cos(angle + 2 * std::numbers::pi / 3);
  return std::max(std::abs(high), std::abs(low));
}

/// Length of the axial vector of the skew part of G: the angle of the infinitesimal rotation, rad.
double rotation(const Gradient& G) {
  return std::hypot(G[1][0] - G[0][1], G[2][1] - G[1][2], G[0][2] - G[2][0]) / 2;
}

/// det(I + ∇y) for ∇y = G.
double volume_ratio(const Gradient& G) {
  return determinant([&](int i, int j) { return G[i][j] + (i == j); });
}

/// Finds the largest of the values of all ranks; `at(i)` is the location of value i of this rank. Collective.
template <class At>
Largest largest(MPI_Comm comm, const std::vector<double>& values, At&& at) {
  Largest found;
  for (const double value : values)
    if (value > found.value) // false for NaN
      found.value = value;
  MPI_Allreduce(MPI_IN_PLACE, &found.value, 1, MPI_DOUBLE, MPI_MAX, comm);
  std::vector<Simplex::Point> first;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] >= (1 - tie) * found.value)
      if (const Simplex::Point place = at(i); first.empty() || place < first.front())
        first = {place};
  first = gather(comm, first);
  if (!first.empty())
    found.at = *std::ranges::min_element(first);
  return found;
}

/// Midpoint of a cell, bitwise independent of the numbering of the cell's vertices.
template <class Vertex>
Simplex::Point middle(int dim, Vertex&& vertex) {
  std::vector<Simplex::Point> corners(static_cast<std::size_t>(dim) + 1);
  for (int i = 0; i <= dim; ++i)
    std::copy_n(vertex(i), 3, corners[static_cast<std::size_t>(i)].begin());
  std::ranges::sort(corners);
  Simplex::Point at{};
  for (const Simplex::Point& corner : corners)
    for (std::size_t k = 0; k < 3; ++k)
      at[k] += corner[k] / (dim + 1);
  return at;
}

/// Strain around the axis, y_r/r, of a body of revolution: at vertex v of a cell or, for degree 1, at the
/// middle.
double hoop_strain(const Space& space, std::span<const std::int32_t> dofs, std::span<const double> at_dofs,
                   const Gradient& G, const auto& vertex, std::size_t v) {
  const auto vertices = static_cast<std::size_t>(space.dim()) + 1;
  const auto radial = [&](std::size_t dof) {
    return at_dofs[static_cast<std::size_t>(dofs[dof]) * static_cast<std::size_t>(space.dim())];
  };
  double y = 0, r = 0; // sums over the vertices have the same ratio as means
  for (std::size_t i = space.degree() == 1 ? 0 : v; i < (space.degree() == 1 ? vertices : v + 1); ++i) {
    y += radial(i);
    r += vertex(static_cast<int>(i))[0];
  }
  return r > 0 ? y / r : G[0][0]; // its limit on the axis
}

/// ∇y at vertex v of a cell. `slope`: gradients of the barycentric coordinates λ. For degree 2 the basis
/// consists of λ_i (2λ_i − 1) and 4 λ_a λ_b.
Gradient gradient(const Space& space, std::span<const std::int32_t> dofs, std::span<const double> at_dofs,
                  const std::array<Simplex::Point, 4>& slope, const std::vector<std::vector<int>>& edges,
                  std::size_t v) {
  const auto n = static_cast<std::size_t>(space.dim()), vertices = n + 1;
  Gradient G{};
  const auto add = [&](std::size_t dof, double factor, const Simplex::Point& direction) {
    for (std::size_t r = 0; r < n; ++r)
      for (std::size_t c = 0; c < n; ++c)
        G[r][c] += factor * direction[c] * at_dofs[static_cast<std::size_t>(dofs[dof]) * n + r];
  };
  for (std::size_t i = 0; i < vertices; ++i)
    add(i, space.degree() == 1 ? 1 : i == v ? 3 : -1, slope[i]);
  for (std::size_t e = 0; space.degree() == 2 && e < edges.size(); ++e)
    for (int end : {0, 1})
      if (static_cast<std::size_t>(edges[e][static_cast<std::size_t>(end)]) == v)
        add(vertices + e, 4, slope[static_cast<std::size_t>(edges[e][static_cast<std::size_t>(1 - end)])]);
  return G;
}

/// ∇y in the cells that this rank owns.
class CellGradients {
public:
  /// Collective.
  CellGradients(const Space& space, Vec y)
      : space_(space), geometry_(space.mesh().dolfinx()->geometry()), cells_(space.mesh().owned_cells()),
        edges_(basix::cell::topology(space.dim() == 2 ? basix::cell::type::triangle
                                                      : basix::cell::type::tetrahedron)[1]),
        values_(space.dolfinx()->dofmap()->index_map, space.dim()) {
    {
      const petsc::ReadArray owned(y);
      const std::span<const double> all = owned; // those of virtual nodes follow
      std::ranges::copy(all.first(space.layout().mesh_dofs()), dolfinx_versions::entries(values_).begin());
    }
    values_.scatter_fwd();
  }

  [[nodiscard]] std::size_t cells() const { return cells_.size(); }
  /// Number of points of each cell at which ∇y is taken: its vertices or, for degree 1, where ∇y is constant,
  /// its midpoint.
  [[nodiscard]] std::size_t samples() const {
    return space_.degree() == 1 ? 1 : static_cast<std::size_t>(space_.dim()) + 1;
  }
  [[nodiscard]] auto vertices(std::size_t i) const {
    return dolfinx_versions::vertices(geometry_, cells_[i]);
  }
  [[nodiscard]] Simplex simplex(std::size_t i) const { return {space_.dim(), vertices(i)}; }
  [[nodiscard]] Simplex::Point midpoint(std::size_t i) const { return middle(space_.dim(), vertices(i)); }

  /// Calls visit(v, ∇y) for the points v of cell i.
  template <class Visit>
  void each(std::size_t i, Visit&& visit) const {
    const Simplex cell = simplex(i);
    std::array<Simplex::Point, 4> slope{}; // gradients of the barycentric coordinates
    for (int corner = 0; corner <= space_.dim(); ++corner)
      slope[corner] = cell.gradient(corner);
    const auto dofs = space_.dolfinx()->dofmap()->cell_dofs(cells_[i]);
    const std::span<const double> at_dofs = values_.array();
    for (std::size_t v = 0; v < samples(); ++v) {
      Gradient G = gradient(space_, dofs, at_dofs, slope, edges_, v);
      if (space_.mesh().axisymmetric())
        G[2][2] = hoop_strain(space_, dofs, at_dofs, G, vertices(i), v);
      visit(v, G);
    }
  }

  /// Place of point v of cell i.
  [[nodiscard]] Simplex::Point place(std::size_t i, std::size_t v) const {
    if (space_.degree() == 1)
      return midpoint(i);
    const double* corner = vertices(i)(static_cast<int>(v));
    return {corner[0], corner[1], corner[2]};
  }

private:
  const Space& space_;
  const dolfinx::mesh::Geometry<double>& geometry_;
  std::vector<std::int32_t> cells_;
  std::vector<std::vector<int>> edges_;
  dolfinx::la::Vector<double> values_;
};

/// Longest edge of a cell, m.
template <class Vertex>
double diameter(int dim, Vertex&& vertex) {
  double longest = 0;
  for (int i = 0; i <= dim; ++i)
    for (int j = 0; j < i; ++j)
      longest = std::max(longest, std::hypot(vertex(i)[0] - vertex(j)[0], vertex(i)[1] - vertex(j)[1],
                                             vertex(i)[2] - vertex(j)[2]));
  return longest;
}

} // namespace

Deformation deformation(const Space& space, Vec y) {
  const CellGradients gradients(space, y);
  const std::size_t samples = gradients.samples();
  Deformation found;
  std::vector<double> strains, rotations;
  double most = 0;
  for (std::size_t i = 0; i < gradients.cells(); ++i) {
    bool inverted = false;
    gradients.each(i, [&](std::size_t, const Gradient& G) {
      strains.push_back(principal_strain(G, (1 - tie) * most));
      most = std::max(most, strains.back());
      rotations.push_back(rotation(G));
      // Cells that pass through the axis change the sign of the volume twice.
      inverted = inverted || !(volume_ratio(G) > 0) || (space.mesh().axisymmetric() && !(1 + G[2][2] > 0));
    });
    found.inverted += inverted;
  }
  const auto at = [&](std::size_t i) { return gradients.place(i / samples, i % samples); };
  found.strain = largest(space.comm(), strains, at);
  found.rotation = largest(space.comm(), rotations, at);
  MPI_Allreduce(MPI_IN_PLACE, &found.inverted, 1, MPI_INT64_T, MPI_SUM, space.comm());
  return found;
}

double strain_around(const Space& space, Vec y, const std::array<double, 3>& at) {
  const CellGradients gradients(space, y);
  double reach = 0;
  for (std::size_t i = 0; i < gradients.cells(); ++i)
    for (std::size_t v = 0; v < gradients.samples(); ++v)
      if (gradients.place(i, v) == at)
        reach = std::max(reach, diameter(space.dim(), gradients.vertices(i)));
  MPI_Allreduce(MPI_IN_PLACE, &reach, 1, MPI_DOUBLE, MPI_MAX, space.comm());
  std::array<double, 10> sums{}; // of the sizes, and of ∇y weighted with them
  for (std::size_t i = 0; i < gradients.cells(); ++i) {
    const Simplex::Point x = gradients.midpoint(i);
    if (std::hypot(x[0] - at[0], x[1] - at[1], x[2] - at[2]) > reach)
      continue;
    const double size = gradients.simplex(i).abs_determinant();
    sums[9] += size;
    gradients.each(i, [&](std::size_t, const Gradient& G) {
      for (std::size_t k = 0; k < 9; ++k)
        sums[k] += size * G[k / 3][k % 3] / static_cast<double>(gradients.samples());
    });
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, space.comm());
  Gradient mean{};
  for (std::size_t k = 0; k < 9 && sums[9] > 0; ++k)
    mean[k / 3][k % 3] = sums[k] / sums[9];
  return principal_strain(mean, 0);
}

double mean_diameter(const Space& space) {
  const auto& geometry = space.mesh().dolfinx()->geometry();
  const int dim = space.dim();
  std::array<double, 2> sums{}; // of volumes times diameters, and of volumes
  for (std::int32_t cell : space.mesh().owned_cells()) {
    const auto vertex = dolfinx_versions::vertices(geometry, cell);
    const double volume = Simplex(dim, vertex).abs_determinant();
    sums[0] += volume * diameter(dim, vertex);
    sums[1] += volume;
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, space.comm());
  return sums[0] / sums[1];
}

Largest largest(const Space& space, const std::vector<double>& of_cells) {
  const auto& geometry = space.mesh().dolfinx()->geometry();
  const std::vector<std::int32_t> cells = space.mesh().owned_cells();
  return largest(space.comm(), of_cells, [&](std::size_t i) {
    return middle(space.dim(), dolfinx_versions::vertices(geometry, cells[i]));
  });
}

} // namespace signorini::fem
