#include "contact/full_vi.h"
#include <algorithm>
#include <array>
#include <cmath>

namespace signorini::contact {
using petsc::check;

namespace {

/// An orthonormal frame (dim × dim, row by row) whose first column is ν: the reflection that takes e_1 to ±ν.
std::array<double, 9> frame(const double* nu, int dim) {
  std::array<double, 3> w{};
  const double sign = nu[0] >= 0 ? 1 : -1; // away from cancellation
  double ww = 0;
  for (int c = 0; c < dim; ++c)
    w[c] = nu[c] + (c == 0 ? sign : 0), ww += w[c] * w[c];
  std::array<double, 9> F{};
  for (int i = 0; i < dim; ++i)
    for (int j = 0; j < dim; ++j)
      F[i * dim + j] = ((i == j) - 2 * w[i] * w[j] / ww) * (j == 0 ? -sign : 1);
  return F;
}

petsc::Matrix frames(const Constraints& constraints, Mat D) {
  const int dim = constraints.dim();
  petsc::Matrix Q;
  PetscInt rows = 0, begin = 0, end = 0;
  check(MatGetLocalSize(D, &rows, nullptr));
  check(MatGetOwnershipRange(D, &begin, &end));
  check(MatCreateAIJ(petsc::comm(D), rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, dim, nullptr, 0, nullptr,
                     Q.put()));
  for (PetscInt i = begin; i < end; ++i)
    check(MatSetValue(Q, i, i, 1, INSERT_VALUES));
  for (int i = 0; i < constraints.count(); ++i) {
    const PetscInt first = constraints.first_dofs()[i];
    if (first < begin || first >= end)
      continue;
    std::array<PetscInt, 3> dofs{first, first + 1, first + 2};
    const std::array<double, 9> F = frame(&constraints.normals()[i * dim], dim);
    check(MatSetValues(Q, dim, dofs.data(), dim, dofs.data(), F.data(), INSERT_VALUES));
  }
  check(MatAssemblyBegin(Q, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(Q, MAT_FINAL_ASSEMBLY));
  return Q;
}

} // namespace

FullVi::FullVi(const Constraints& constraints, Mat D, const Complementarity& complementarity)
    : constraints_(constraints), complementarity_(complementarity), length_unit_(constraints.gap_tolerance()),
      Q_(frames(constraints, D)) {
  petsc::Matrix rows; // PETSc multiplies and extracts by rows, not by blocks
  check(MatConvert(D, MATAIJ, MAT_INITIAL_MATRIX, rows.put()));
  check(MatPtAP(rows, Q_, MAT_INITIAL_MATRIX, PETSC_DEFAULT, D_.put()));
  check(MatCreateVecs(D_, z_.put(), r_.put()));
  PetscReal largest = 1;
  check(MatGetDiagonal(D_, r_));
  check(VecMax(r_, nullptr, &largest));
  check(MatScale(D_, 1 / largest));
  force_unit_ = length_unit_ * largest;
  petsc::Vector lower = petsc::zero_like(z_), upper = petsc::zero_like(z_);
  check(VecSet(lower, PETSC_NINFINITY));
  check(VecSet(upper, PETSC_INFINITY));
  PetscInt begin = 0, end = 0;
  check(VecGetOwnershipRange(upper, &begin, &end));
  {
    const petsc::WriteArray bound(upper);
    for (int i = 0; i < constraints.count(); ++i)
      if (const PetscInt dof = constraints.first_dofs()[i]; dof >= begin && dof < end)
        bound[dof - begin] = constraints.psi()[i] / length_unit_;
  }
  vi_.emplace("full_vi", D_, std::move(lower), std::move(upper), MATSOLVERMUMPS);
}

void FullVi::solve(Vec r, const ContactState&, ContactState& state, Vec y) const {
  check(MatMultTranspose(Q_, r, r_));
  check(VecScale(r_, -1 / force_unit_));
  check(MatMultTranspose(Q_, y, z_));
  check(VecScale(z_, 1 / length_unit_));
  state.vi_iterations = vi_->solve(r_, z_);
  count_solved();

  const std::size_t m = static_cast<std::size_t>(constraints_.count());
  std::ranges::fill(state.lambda, 0);
  PetscInt begin = 0, end = 0;
  check(VecGetOwnershipRange(z_, &begin, &end));
  {
    const petsc::ReadArray residual(vi_->residual()), z(z_), upper(vi_->upper());
    // A warm start from the bound can come a rounding below it, and the solver leaves it there: one unit, the
    // gap tolerance, is no distance.
    for (std::size_t i = 0; i < m; ++i)
      if (const PetscInt dof = constraints_.first_dofs()[i];
          dof >= begin && dof < end && z[dof - begin] >= upper[dof - begin] - 1)
        state.lambda[i] = std::max(0.0, -force_unit_ * residual[dof - begin]);
  }
  MPI_Allreduce(MPI_IN_PLACE, state.lambda.data(), static_cast<int>(m), MPI_DOUBLE, MPI_SUM, petsc::comm(r_));
  check(VecScale(z_, length_unit_));
  check(MatMult(Q_, z_, y));
  constraints_.gap(y, state.gap);
  complementarity_.classify(state);
}

} // namespace signorini::contact
