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
  check(MatZeroRowsColumns(matrix, static_cast<PetscInt>(rows.size()), rows.data(), largest, nullptr, nullptr));
}

Operators assemble_operators(const Space& space, const scene::Material& material) {
  constexpr double no_tau = 0; // none of these forms has a time step
  Operators operators{assemble(space, Form::L2, material, no_tau), assemble(space, Form::m, material, no_tau),
                      assemble(space, Form::a, material, no_tau), std::nullopt};
  if (material.viscosity)
    operators.B = assemble(space, Form::b, material, no_tau);
  return operators;
}

petsc::Matrix assemble_step_operator(const Space& space, const scene::Material& material, double tau) {
  petsc::Matrix D = assemble(space, material.viscosity ? Form::d : Form::d_elastic, material, tau);
  check(MatSetOption(D, MAT_SPD, PETSC_TRUE));
  check(MatSetOption(D, MAT_SPD_ETERNAL, PETSC_TRUE));
  return D;
}

} // namespace signorini::fem
