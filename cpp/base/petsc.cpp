// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/petsc.h"
#include "base/error.h"
#include <cmath>
#include <fmt/format.h>
#include <new>
#include <string>

namespace signorini::petsc {
namespace {

std::string& first_message() {
  static std::string text;
  return text;
}

PetscErrorCode keep_message(MPI_Comm, int, const char*, const char*, PetscErrorCode ierr, PetscErrorType type,
                            const char* message, void*) {
  if (type == PETSC_ERROR_INITIAL)
    first_message() = message ? message : "";
  return ierr;
}

} // namespace

void check(PetscErrorCode ierr, std::source_location where) {
  if (ierr == PETSC_SUCCESS)
    return;
  if (ierr == PETSC_ERR_MEM)
    throw std::bad_alloc();
  const char* kind = nullptr;
  (void)PetscErrorMessage(ierr, &kind, nullptr);
  std::string detail = std::exchange(first_message(), {});
  throw SolverFailure(fmt::format("PETSc failed in {}: {}{}{}", where.function_name(),
                                  kind ? kind : fmt::format("error {}", static_cast<int>(ierr)),
                                  detail.empty() ? "" : ": ", detail));
}

void keep_error_messages() { check(PetscPushErrorHandler(keep_message, nullptr)); }

Vector zero_like(Vec x) {
  Vector y;
  check(VecDuplicate(x, y.put()));
  check(VecZeroEntries(y));
  return y;
}

Vector copy(Vec x) {
  Vector y;
  check(VecDuplicate(x, y.put()));
  check(VecCopy(x, y));
  return y;
}

void combine(Vec out, double a, Vec x, double b, Vec y) {
  // With a = 1 VecAXPBYPCZ() adds 0 times the old values of `out`: nan where a sweep failed.
  if (a == 1)
    check(VecWAXPY(out, b, y, x));
  else
    check(VecAXPBYPCZ(out, a, b, 0, x, y));
}

Vector vector_of(Mat matrix) {
  Vector x;
  check(MatCreateVecs(matrix, x.put(), nullptr));
  check(VecZeroEntries(x));
  return x;
}

Series zero_series(Vec x, std::size_t count) {
  Series series;
  series.reserve(count);
  for (std::size_t i = 0; i < count; ++i)
    series.push_back(zero_like(x));
  return series;
}

Mat component(Mat matrix) {
  PetscBool compressed = PETSC_FALSE;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(matrix), &compressed, MATMAIJ, MATSEQMAIJ,
                                  MATMPIMAIJ, ""));
  Mat stored = nullptr;
  if (compressed)
    check(MatMAIJGetAIJ(matrix, &stored));
  return stored;
}

double bytes(Mat matrix) {
  const Mat one = component(matrix), stored = one ? one : matrix;
  PetscBool blocks = PETSC_FALSE;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(matrix), &blocks, MATSEQBAIJ, MATMPIBAIJ,
                                  MATSEQSBAIJ, MATMPISBAIJ, ""));
  PetscInt size = 1, rows = 0;
  if (blocks)
    check(MatGetBlockSize(matrix, &size));
  check(MatGetSize(stored, &rows, nullptr));
  MatInfo info;
  check(MatGetInfo(stored, MAT_GLOBAL_SUM, &info));
  return info.nz_used * (sizeof(PetscScalar) +
                         static_cast<double>(sizeof(PetscInt)) / static_cast<double>(size * size)) +
         static_cast<double>(sizeof(PetscInt)) * static_cast<double>(rows / size);
}

double dot(Vec x, Vec y) {
  PetscScalar value = 0;
  check(VecDot(x, y, &value));
  return value;
}

void Pairing::add(Vec x, Vec y) {
  PetscReal one = 0, other = 0;
  check(VecNorm(x, NORM_2, &one));
  check(VecNorm(y, NORM_2, &other));
  value += dot(x, y);
  size += one * other;
}

double Pairing::defect(double other) const {
  const double difference = std::abs(other - value);
  return difference > 0 ? difference / size : 0;
}

MPI_Comm comm(PetscObject object) {
  MPI_Comm c = MPI_COMM_NULL;
  check(PetscObjectGetComm(object, &c));
  return c;
}

void default_option(const char* name, const char* key, const char* value) {
  const std::string option = fmt::format("-{}_{}", name, key);
  PetscBool set = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, option.c_str(), &set));
  if (!set)
    check(PetscOptionsSetValue(nullptr, option.c_str(), value));
}

} // namespace signorini::petsc
