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
  for (const auto& [key, value] : {std::pair{"snes_vi_zero_tolerance", "1e-3"},
                                   {"snes_max_it", "100"},
                                   {"snes_linesearch_type", "basic"},
                                   {"ksp_type", "preonly"},
                                   {"pc_type", "lu"},
                                   {"pc_factor_mat_solver_type", package}})
    petsc::default_option(name.c_str(), key, value);
  check(SNESCreate(petsc::comm(K), snes_.put()));
  check(SNESSetOptionsPrefix(snes_, (name + "_").c_str()));
  check(SNESSetType(snes_, SNESVINEWTONRSLS));
  check(SNESSetFunction(snes_, residual_, evaluate, static_cast<Vec>(constant_)));
  check(SNESSetJacobian(snes_, K, K, constant_jacobian, nullptr));
  check(SNESVISetVariableBounds(snes_, lower_, upper_));
  check(SNESSetFromOptions(snes_));
}

int LinearVi::solve(Vec c, Vec x, double tolerance) const {
  check(VecCopy(c, constant_));
  check(VecCopy(x, start_));
  // The Newton steps are exact, so the residual falls to rounding once the set is right, and no other test is needed.
  check(SNESSetTolerances(snes_, tolerance, 0, 0, PETSC_CURRENT, PETSC_CURRENT));
  int iterations = 0;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscReal norm = 0;
  for (const SNESType type : {SNESVINEWTONRSLS, SNESVINEWTONSSLS}) {
    check(SNESSetType(snes_, type));
    check(VecCopy(start_, x));
    check(SNESSolve(snes_, nullptr, x));
    check(SNESGetConvergedReason(snes_, &reason));
    check(SNESGetFunctionNorm(snes_, &norm));
    PetscInt its = 0;
    check(SNESGetIterationNumber(snes_, &its));
    iterations += static_cast<int>(its);
    if (reason > 0) {
      check(SNESComputeFunction(snes_, x, residual_));
      return iterations;
    }
  }
  throw SolverFailure(fmt::format("the {} did not converge: {}, residual {:.3e} (allowed {:.3e}) after {} iterations", name_,
                                  SNESConvergedReasons[reason], norm, tolerance, iterations));
}

} // namespace signorini::contact
