#include "contact/full_vi.h"
#include <array>
#include <cmath>

namespace signorini::contact {
using petsc::check;

namespace {

PetscErrorCode linear_residual(SNES snes, Vec z, Vec residual, void*) {
  PetscFunctionBeginUser;
  Mat D = nullptr;
  Vec r = nullptr;
  PetscCall(SNESGetJacobian(snes, &D, nullptr, nullptr, nullptr));
  PetscCall(SNESGetApplicationContext(snes, &r));
  PetscCall(MatMult(D, z, residual));
  PetscCall(VecAXPY(residual, -1, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode constant_jacobian(SNES, Vec, Mat, Mat, void*) { return PETSC_SUCCESS; }

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
  check(MatCreateAIJ(petsc::comm(D), rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, dim, nullptr, 0, nullptr, Q.put()));
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
    : constraints_(constraints), complementarity_(complementarity), Q_(frames(constraints, D)) {
  check(MatPtAP(D, Q_, MAT_INITIAL_MATRIX, PETSC_DEFAULT, D_.put()));
  check(MatCreateVecs(D_, z_.put(), residual_.put()));
  for (petsc::Vector* v : {&start_, &r_, &lower_, &upper_})
    *v = petsc::zero_like(z_);
  check(MatGetDiagonal(D_, r_));
  PetscReal largest = 1;
  check(VecMax(r_, nullptr, &largest));
  check(MatScale(D_, 1 / largest));
  length_unit_ = constraints.gap_tolerance();
  force_unit_ = length_unit_ * largest;
  check(VecSet(lower_, PETSC_NINFINITY));
  check(VecSet(upper_, PETSC_INFINITY));
  PetscInt begin = 0, end = 0;
  check(VecGetOwnershipRange(upper_, &begin, &end));
  {
    const petsc::WriteArray upper(upper_);
    for (int i = 0; i < constraints.count(); ++i)
      if (const PetscInt dof = constraints.first_dofs()[i]; dof >= begin && dof < end)
        upper[dof - begin] = constraints.psi()[i] / length_unit_;
  }
  constexpr const char* name = "full_vi";
  petsc::default_option(name, "snes_vi_zero_tolerance", "1e-3");
  petsc::default_option(name, "snes_rtol", "0");
  petsc::default_option(name, "snes_stol", "0");
  petsc::default_option(name, "snes_max_it", "100");
  petsc::default_option(name, "snes_linesearch_type", "basic");
  petsc::default_option(name, "ksp_type", "preonly");
  petsc::default_option(name, "pc_type", "lu");
  petsc::default_option(name, "pc_factor_mat_solver_type", MATSOLVERMUMPS);
  check(SNESCreate(petsc::comm(D), snes_.put()));
  check(SNESSetOptionsPrefix(snes_, "full_vi_"));
  check(SNESSetType(snes_, SNESVINEWTONRSLS));
  check(SNESSetFunction(snes_, residual_, linear_residual, nullptr));
  check(SNESSetJacobian(snes_, D_, D_, constant_jacobian, nullptr));
  check(SNESSetApplicationContext(snes_, static_cast<Vec>(r_)));
  check(SNESVISetVariableBounds(snes_, lower_, upper_));
  check(SNESSetFromOptions(snes_));
}

ContactState FullVi::solve(Vec r, const ContactState&, Vec y) const {
  ContactState state;
  check(MatMultTranspose(Q_, r, r_));
  check(VecScale(r_, 1 / force_unit_));
  check(MatMultTranspose(Q_, y, z_));
  check(VecScale(z_, 1 / length_unit_));
  PetscReal size = 0;
  check(VecNorm(r_, NORM_2, &size));
  // The Newton steps are exact, so the residual falls to rounding once the set is right; between, it stays far above this.
  check(SNESSetTolerances(snes_, 1e-11 * size, PETSC_CURRENT, PETSC_CURRENT, PETSC_CURRENT, PETSC_CURRENT));
  state.vi_iterations = solve_vi(snes_, z_, start_, "full");
  check(MatMult(D_, z_, residual_));
  check(VecAXPY(residual_, -1, r_));

  const std::size_t m = static_cast<std::size_t>(constraints_.count());
  state.lambda.assign(m, 0);
  state.gap.resize(m);
  PetscInt begin = 0, end = 0;
  check(VecGetOwnershipRange(residual_, &begin, &end));
  {
    const petsc::ReadArray residual(residual_), z(z_), upper(upper_);
    for (std::size_t i = 0; i < m; ++i)
      if (const PetscInt dof = constraints_.first_dofs()[i]; dof >= begin && dof < end && z[dof - begin] >= upper[dof - begin])
        state.lambda[i] = -force_unit_ * residual[dof - begin];
  }
  MPI_Allreduce(MPI_IN_PLACE, state.lambda.data(), static_cast<int>(m), MPI_DOUBLE, MPI_SUM, petsc::comm(r_));
  check(VecScale(z_, length_unit_));
  check(MatMult(Q_, z_, y));
  constraints_.gap(y, state.gap);
  complementarity_.classify(state);
  return state;
}

} // namespace signorini::contact
