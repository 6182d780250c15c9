#include "fem/operators.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::fem {
using petsc::check;

Clamped::Clamped(const Space& space, const std::vector<scene::Clamp>& clamps)
    : dim_(space.dim()), first_dof_(space.first_dof()) {
  for (std::size_t i = 0; i < clamps.size(); ++i) {
    const std::vector<int> nodes =
        space.nodes_on(clamps[i].on, clamps.size() == 1 ? "clamp.on" : fmt::format("clamp[{}].on", i));
    nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
  }
  std::ranges::sort(nodes_);
  const auto [last, end] = std::ranges::unique(nodes_);
  nodes_.erase(last, end);
}

bool Clamped::contains(int node) const { return std::ranges::binary_search(nodes_, node); }

void Clamped::clear(Vec x) const {
  const petsc::WriteArray values(x);
  for (int node : nodes_)
    for (int c = 0; c < dim_; ++c)
      values[static_cast<std::size_t>(node * dim_ + c)] = 0;
}

void Clamped::decouple(Mat matrix) const {
  petsc::Vector diagonal;
  check(MatCreateVecs(matrix, diagonal.put(), nullptr));
  check(MatGetDiagonal(matrix, diagonal));
  PetscReal largest = 0; // keeps the matrix as well conditioned as its free part, whatever the units
  check(VecMax(diagonal, nullptr, &largest));
  std::vector<PetscInt> rows;
  for (int node : nodes_)
    for (int c = 0; c < dim_; ++c)
      rows.push_back(first_dof_ + node * dim_ + c);
  check(
      MatZeroRowsColumns(matrix, static_cast<PetscInt>(rows.size()), rows.data(), largest, nullptr, nullptr));
}

namespace {

/// One component of a matrix of blocks, acting on all of them (MAIJ), if it does the same; else in blocks.
petsc::Matrix compress(petsc::Matrix rows) {
  PetscInt dim = 1, begin = 0, end = 0;
  check(MatGetBlockSize(rows, &dim));
  check(MatGetOwnershipRange(rows, &begin, &end));
  petsc::IndexSet first;
  check(ISCreateStride(petsc::comm(rows), (end - begin) / dim, begin, dim, first.put()));
  petsc::Matrix component, all;
  check(MatCreateSubMatrix(rows, first, first, MAT_INITIAL_MATRIX, component.put()));
  check(MatCreateMAIJ(component, dim, all.put()));
  petsc::Vector x, exact, same;
  check(MatCreateVecs(rows, x.put(), exact.put()));
  check(VecDuplicate(exact, same.put()));
  check(VecSetRandom(x, nullptr));
  check(MatMult(rows, x, exact));
  check(MatMult(all, x, same));
  PetscReal size = 0, difference = 0;
  check(VecNorm(exact, NORM_INFINITY, &size));
  check(VecAXPY(same, -1, exact));
  check(VecNorm(same, NORM_INFINITY, &difference));
  constexpr double rounding = 1e-13;
  if (difference <= rounding * size)
    return all;
  petsc::Matrix blocks;
  check(MatConvert(rows, MATBAIJ, MAT_INITIAL_MATRIX, blocks.put()));
  return blocks;
}

} // namespace

petsc::Vector diagonal(Mat matrix) {
  petsc::Vector diagonal;
  check(MatCreateVecs(matrix, diagonal.put(), nullptr));
  PetscBool compressed = PETSC_FALSE;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(matrix), &compressed, MATMAIJ, MATSEQMAIJ,
                                  MATMPIMAIJ, ""));
  if (!compressed) {
    check(MatGetDiagonal(matrix, diagonal));
    return diagonal;
  }
  Mat component = nullptr;
  check(MatMAIJGetAIJ(matrix, &component));
  petsc::Vector one;
  check(MatCreateVecs(component, one.put(), nullptr));
  check(MatGetDiagonal(component, one));
  const petsc::ReadArray from(one);
  const petsc::WriteArray to(diagonal);
  const std::size_t dim = to.size() / std::max<std::size_t>(from.size(), 1);
  for (std::size_t i = 0; i < to.size(); ++i)
    to[i] = from[i / dim];
  return diagonal;
}

Operators assemble_operators(const Space& space, const scene::Material& material) {
  constexpr double no_tau = 0; // none of these forms has a time step
  Operators operators{compress(assemble(space, Form::L2, material, no_tau, MATAIJ)),
                      compress(assemble(space, Form::m, material, no_tau, MATAIJ)),
                      assemble(space, Form::a, material, no_tau, MATBAIJ), std::nullopt};
  if (material.viscosity)
    operators.B = assemble(space, Form::b, material, no_tau, MATBAIJ);
  return operators;
}

petsc::Matrix assemble_step_operator(const Space& space, const scene::Material& material, double tau) {
  petsc::Matrix D = assemble(space, material.viscosity ? Form::d : Form::d_elastic, material, tau, MATBAIJ);
  return D;
}

} // namespace signorini::fem
