#include "contact/linear_vi.h"
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

LinearVi::LinearVi(const std::string& name, Mat K, petsc::Vector lower, petsc::Vector upper, const char* package)
    : name_(name), lower_(std::move(lower)), upper_(std::move(upper)), residual_(petsc::zero_like(lower_)),
      start_(petsc::zero_like(lower_)), constant_(petsc::zero_like(lower_)) {
  for (const std::string& solver : {name, name + "_fallback"})
    for (const auto& [key, value] : {std::pair{"snes_vi_zero_tolerance", "1e-3"}, // in units where 1 is negligible
                                     {"snes_atol", "1e-2"},
                                     // Newton steps are exact, so the residual falls to rounding once the set is right.
                                     {"snes_rtol", "0"},
                                     {"snes_stol", "0"},
                                     {"snes_max_it", "100"},
                                     {"snes_force_iteration", "1"},
                                     {"ksp_type", "preonly"},
                                     {"pc_type", "lu"},
                                     {"pc_factor_mat_solver_type", package}})
      petsc::default_option(solver.c_str(), key, value);
  petsc::default_option(name.c_str(), "snes_linesearch_type", "basic");
  first_ = make_solver(name + "_", SNESVINEWTONRSLS, K);
  fallback_ = make_solver(name + "_fallback_", SNESVINEWTONSSLS, K);
}

petsc::NonlinearSolver LinearVi::make_solver(const std::string& prefix, SNESType type, Mat K) const {
  petsc::NonlinearSolver snes;
  check(SNESCreate(petsc::comm(K), snes.put()));
  check(SNESSetOptionsPrefix(snes, prefix.c_str()));
  check(SNESSetType(snes, type));
  check(SNESSetFunction(snes, residual_, evaluate, static_cast<Vec>(constant_)));
  check(SNESSetJacobian(snes, K, K, constant_jacobian, nullptr));
  check(SNESVISetVariableBounds(snes, lower_, upper_));
  check(SNESSetFromOptions(snes));
  return snes;
}

int LinearVi::solve(Vec c, Vec x) const {
  check(VecCopy(c, constant_));
  check(VecCopy(x, start_));
  int iterations = 0;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscReal norm = 0;
  for (const SNES snes : {static_cast<SNES>(first_), static_cast<SNES>(fallback_)}) {
    check(VecCopy(start_, x));
    check(SNESSolve(snes, nullptr, x));
    check(SNESGetConvergedReason(snes, &reason));
    check(SNESGetFunctionNorm(snes, &norm));
    PetscInt its = 0;
    check(SNESGetIterationNumber(snes, &its));
    iterations += static_cast<int>(its);
    if (reason > 0) {
      check(SNESComputeFunction(snes, x, residual_));
      return iterations;
    }
  }
  throw SolverFailure(fmt::format("the {} did not converge: {}, scaled residual {:.3e} after {} iterations", name_,
                                  SNESConvergedReasons[reason], norm, iterations));
}

} // namespace signorini::contact
