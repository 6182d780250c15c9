// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/lcp/snes_vi.h"
#include "base/error.h"
#include <fmt/format.h>

namespace signorini::contact {
using petsc::check;

namespace {

PetscErrorCode evaluate(SNES snes, Vec x, Vec residual, void* constant) {
  PetscFunctionBeginUser;
  Mat K = nullptr;
  PetscCall(SNESGetJacobian(snes, &K, nullptr, nullptr, nullptr));
  PetscCall(MatMultAdd(K, x, static_cast<Vec>(constant), residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode constant_jacobian(SNES, Vec, Mat, Mat, void*) { return PETSC_SUCCESS; }

} // namespace

SnesVi::SnesVi(const std::string& name, Mat K, petsc::Vector lower, petsc::Vector upper, const char* package)
    : name_(name), lower_(std::move(lower)), upper_(std::move(upper)), residual_(petsc::zero_like(lower_)),
      constant_(petsc::zero_like(lower_)) {
  for (const auto& [key, value] :
       {std::pair{"snes_vi_zero_tolerance", "1e-3"}, // in units where 1 is negligible
        {"snes_atol", "1e-2"},
        // A Newton step on the right set is exact, so the residual then falls to rounding.
        {"snes_rtol", "0"},
        {"snes_stol", "0"},
        {"snes_max_it", "100"},
        {"snes_force_iteration", "1"},
        {"snes_linesearch_type", "basic"},
        {"ksp_type", "preonly"},
        {"pc_type", "lu"},
        {"pc_factor_mat_solver_type", package},
        // Extra workspace, per cent: MUMPS's own estimate sometimes falls short, depending on its ranks'
        // load.
        {"mat_mumps_icntl_14", "200"}})
    petsc::default_option(name.c_str(), key, value);
  check(SNESCreate(petsc::comm(K), snes_.put()));
  check(SNESSetOptionsPrefix(snes_, (name + "_").c_str()));
  check(SNESSetType(snes_, SNESVINEWTONRSLS));
  check(SNESSetFunction(snes_, residual_, evaluate, static_cast<Vec>(constant_)));
  check(SNESSetJacobian(snes_, K, K, constant_jacobian, nullptr));
  check(SNESVISetVariableBounds(snes_, lower_, upper_));
  check(SNESSetFromOptions(snes_));
}

int SnesVi::solve(Vec c, Vec x) const {
  check(VecCopy(c, constant_));
  check(SNESSolve(snes_, nullptr, x));
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscReal norm = 0;
  PetscInt iterations = 0;
  check(SNESGetConvergedReason(snes_, &reason));
  check(SNESGetFunctionNorm(snes_, &norm));
  check(SNESGetIterationNumber(snes_, &iterations));
  if (reason < 0)
    throw SolverFailure(fmt::format("the {} did not converge: {}, scaled residual {:.3e} after {} iterations",
                                    name_, SNESConvergedReasons[reason], norm, static_cast<int>(iterations)));
  check(SNESComputeFunction(snes_, x, residual_));
  return static_cast<int>(iterations);
}

} // namespace signorini::contact
