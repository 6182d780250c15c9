#include "fem/enrichment.h"
#include "fem/simplex.h"
#include <array>
#include <basix/cell.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/mesh/Mesh.h>

namespace signorini::fem {
using petsc::check;

namespace {

using Point = Simplex::Point;

/// A matrix between the nodes of two spaces.
petsc::Matrix between(const Space& rows, const Space& columns) {
  petsc::Matrix matrix;
  check(MatCreate(rows.comm(), matrix.put()));
  check(MatSetSizes(matrix, rows.owned_nodes(), columns.owned_nodes(), PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(matrix, MATAIJ));
  check(MatSetUp(matrix));
  return matrix;
}

void assemble(Mat matrix) {
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
}

/// A cell's nodes by their numbers among all, and its vertices.
struct Cell {
  std::vector<PetscInt> linear, quadratic;
  std::array<Point, 4> x{};
};

template <class Visit>
void for_each_owned_cell(const Space& linear, const Space& quadratic, Visit&& visit) {
  const auto one = linear.dolfinx()->dofmap(), two = quadratic.dolfinx()->dofmap();
  const std::vector<double> points = linear.dolfinx()->tabulate_dof_coordinates(false);
  const auto numbers = [](const auto& dofmap, std::int32_t c) {
    const auto local = dofmap->cell_dofs(c);
    std::vector<std::int64_t> global(local.size());
    dofmap->index_map->local_to_global(local, global);
    return std::vector<PetscInt>(global.begin(), global.end());
  };
  for (std::int32_t c : linear.mesh().owned_cells()) {
    Cell cell{numbers(one, c), numbers(two, c)};
    const auto local = one->cell_dofs(c);
    for (std::size_t i = 0; i < local.size(); ++i)
      std::copy_n(&points[3 * static_cast<std::size_t>(local[i])], 3, cell.x[i].begin());
    visit(cell);
  }
}

/// ∂/∂x_c averaged at the nodes.
std::vector<petsc::Matrix> averaged_gradient(const Space& linear, const Space& quadratic) {
  const int dim = linear.dim();
  std::vector<petsc::Matrix> gradient;
  for (int c = 0; c < dim; ++c)
    gradient.push_back(between(linear, linear));
  petsc::Vector volume;
  check(MatCreateVecs(gradient.front(), nullptr, volume.put()));
  for_each_owned_cell(linear, quadratic, [&](const Cell& cell) {
    const Simplex simplex(dim, [&](int i) { return cell.x[i]; });
    for (PetscInt row : cell.linear) {
      check(VecSetValue(volume, row, simplex.volume(), ADD_VALUES));
      for (std::size_t j = 0; j < cell.linear.size(); ++j) {
        const Point phi = simplex.gradient(static_cast<int>(j));
        for (int c = 0; c < dim; ++c)
          check(MatSetValue(gradient[c], row, cell.linear[j], simplex.volume() * phi[c], ADD_VALUES));
      }
    }
  });
  check(VecAssemblyBegin(volume));
  check(VecAssemblyEnd(volume));
  check(VecReciprocal(volume));
  for (const petsc::Matrix& component : gradient) {
    assemble(component);
    check(MatDiagonalScale(component, volume, nullptr));
  }
  return gradient;
}

petsc::Matrix all_components(const petsc::Matrix& one, int dim) {
  petsc::Matrix all;
  check(MatCreateMAIJ(one, dim, all.put()));
  return all;
}

} // namespace

Enrichment enrich(const Space& linear, const Space& quadratic) {
  const int dim = linear.dim();
  const auto cell_type = dim == 2 ? basix::cell::type::triangle : basix::cell::type::tetrahedron;
  const std::vector<std::vector<int>> edges = basix::cell::topology(cell_type)[1];
  const petsc::Matrix embed = between(quadratic, linear);
  std::vector<petsc::Matrix> bend; // (y_a − y_b)(x_b − x_a)_c / 8
  for (int c = 0; c < dim; ++c)
    bend.push_back(between(quadratic, linear));
  for_each_owned_cell(linear, quadratic, [&](const Cell& cell) {
    for (std::size_t i = 0; i < cell.linear.size(); ++i)
      check(MatSetValue(embed, cell.quadratic[i], cell.linear[i], 1, INSERT_VALUES));
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const PetscInt middle = cell.quadratic[cell.linear.size() + e];
      const auto a = static_cast<std::size_t>(edges[e][0]), b = static_cast<std::size_t>(edges[e][1]);
      const auto along = [&](int c) { return cell.x[b][c] - cell.x[a][c]; };
      for (std::size_t end : {a, b})
        check(MatSetValue(embed, middle, cell.linear[end], 0.5, INSERT_VALUES));
      for (int c = 0; c < dim; ++c) {
        check(MatSetValue(bend[c], middle, cell.linear[a], along(c) / 8, INSERT_VALUES));
        check(MatSetValue(bend[c], middle, cell.linear[b], -along(c) / 8, INSERT_VALUES));
      }
    }
  });
  assemble(embed);
  const std::vector<petsc::Matrix> gradient = averaged_gradient(linear, quadratic);
  petsc::Matrix surplus;
  for (int c = 0; c < dim; ++c) {
    assemble(bend[c]);
    petsc::Matrix part;
    check(MatMatMult(bend[c], gradient[c], MAT_INITIAL_MATRIX, PETSC_DEFAULT, part.put()));
    if (c == 0)
      surplus = std::move(part);
    else
      check(MatAXPY(surplus, 1, part, DIFFERENT_NONZERO_PATTERN));
  }
  return {all_components(embed, dim), all_components(surplus, dim)};
}

} // namespace signorini::fem
