// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/threaded_product.h"
#include "base/petsc.h"
#include <algorithm>
#include <memory>
#include <omp.h>
#include <vector>

namespace signorini {
namespace {

using petsc::check;

constexpr const char* attached = "signorini_threaded_product";
/// Number of stored entries above which threads save more time than their synchronisation takes.
constexpr std::ptrdiff_t worth_threads = 50'000;
/// Number of parts with equal work into which the rows of a matrix that is worth threads are divided.
constexpr std::ptrdiff_t parts_wanted = 32;

/// Product y = A x + z with one matrix A; a null z counts as zero, and y may be z.
class Product {
public:
  virtual ~Product() = default;
  virtual void operator()(const double* x, const double* z, double* y) = 0;
};

/// Matrix in compressed rows.
struct Rows {
  PetscInt count = 0;
  const PetscInt *begin = nullptr, *column = nullptr;
  const PetscScalar* values = nullptr;
};

/// Divides rows into parts with about equally many entries of `size` numbers; one part if they are few.
/// Returns the first row of each part and, at the end, the number of rows.
std::vector<PetscInt> parts(const Rows& rows, std::ptrdiff_t size) {
  std::vector<PetscInt> first{0};
  const std::ptrdiff_t entries = rows.begin[rows.count],
                       count = entries * size < worth_threads ? 1 : parts_wanted;
  for (std::ptrdiff_t part = 1; part < count; ++part) {
    const PetscInt* const found =
        std::lower_bound(rows.begin, rows.begin + rows.count, part * entries / count);
    first.push_back(static_cast<PetscInt>(found - rows.begin));
  }
  first.push_back(rows.count);
  return first;
}

/// Product with a symmetric matrix stored as its upper half in blocks. The contributions of each part to rows
/// of later parts are stored separately and added in the order of the parts.
template <int size>
class SymmetricProduct final : public Product {
public:
  explicit SymmetricProduct(const Rows& rows)
      : rows_(rows), first_(parts(rows, size * size)), reached_(first_.size() - 1) {
    for (std::size_t p = 0; p < reached_.size(); ++p) {
      const PetscInt end = first_[p + 1];
      PetscInt last = end - 1;
      for (PetscInt e = rows.begin[first_[p]]; e < rows.begin[end]; ++e)
        last = std::max(last, rows.column[e]);
      reached_[p].resize(static_cast<std::size_t>((last + 1 - end) * size));
    }
  }

  void operator()(const double* x, const double* z, double* y) override {
    if (reached_.size() == 1)
      return multiply(0, x, z, y);
#pragma omp parallel
    {
#pragma omp for schedule(dynamic, 1)
      for (std::size_t p = 0; p < reached_.size(); ++p)
        multiply(p, x, z, y);
#pragma omp for schedule(dynamic, 1)
      for (std::size_t p = 0; p < reached_.size(); ++p)
        collect(p, y);
    }
  }

private:
  void multiply(std::size_t p, const double* x, const double* z, double* y) {
    const PetscInt begin = first_[p], end = first_[p + 1];
    if (!z)
      std::fill(y + begin * size, y + end * size, 0.0);
    else if (z != y)
      std::copy(z + begin * size, z + end * size, y + begin * size);
    std::ranges::fill(reached_[p], 0.0);
    double* const later = reached_[p].data() - static_cast<std::ptrdiff_t>(end) * size;
    for (PetscInt i = begin; i < end; ++i) {
      const double* const xi = x + i * size;
      double sum[size] = {};
      for (PetscInt e = rows_.begin[i]; e < rows_.begin[i + 1]; ++e) {
        const PetscInt j = rows_.column[e];
        const double* const block = rows_.values + static_cast<std::ptrdiff_t>(e) * size * size; // by columns
        const double* const xj = x + j * size;
        for (int c = 0; c < size; ++c)
          for (int r = 0; r < size; ++r)
            sum[r] += block[c * size + r] * xj[c];
        if (j == i)
          continue;
        double* const yj = (j < end ? y : later) + static_cast<std::ptrdiff_t>(j) * size;
        for (int c = 0; c < size; ++c) {
          double product = 0;
          for (int r = 0; r < size; ++r)
            product += block[c * size + r] * xi[r];
          yj[c] += product;
        }
      }
      for (int r = 0; r < size; ++r)
        y[i * size + r] += sum[r];
    }
  }

  /// Adds the contributions of the earlier parts to the rows of part p.
  void collect(std::size_t p, double* y) {
    const std::ptrdiff_t begin = static_cast<std::ptrdiff_t>(first_[p]) * size,
                         end = static_cast<std::ptrdiff_t>(first_[p + 1]) * size;
    for (std::size_t q = 0; q < p; ++q) {
      const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(first_[q + 1]) * size,
                           stop = start + std::ssize(reached_[q]);
      for (std::ptrdiff_t i = std::max(begin, start); i < std::min(end, stop); ++i)
        y[i] += reached_[q][i - start];
    }
  }

  Rows rows_;
  std::vector<PetscInt> first_;
  std::vector<std::vector<double>> reached_; ///< for each part, its contributions to rows after it
};

/// Product with a scalar matrix that is applied to each of `size` components.
template <int size>
class ComponentProduct final : public Product {
public:
  explicit ComponentProduct(const Rows& rows) : rows_(rows), first_(parts(rows, size)) {}

  void operator()(const double* x, const double* z, double* y) override {
    const std::size_t count = first_.size() - 1;
    if (count == 1)
      return multiply(0, x, z, y);
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t p = 0; p < count; ++p)
      multiply(p, x, z, y);
  }

private:
  void multiply(std::size_t p, const double* x, const double* z, double* y) {
    for (PetscInt i = first_[p]; i < first_[p + 1]; ++i) {
      double sum[size] = {};
      for (PetscInt e = rows_.begin[i]; e < rows_.begin[i + 1]; ++e)
        for (int c = 0; c < size; ++c)
          sum[c] += rows_.values[e] * x[rows_.column[e] * size + c];
      for (int c = 0; c < size; ++c)
        y[i * size + c] = z ? z[i * size + c] + sum[c] : sum[c];
    }
  }

  Rows rows_;
  std::vector<PetscInt> first_;
};

template <template <int> class Kind>
std::unique_ptr<Product> product(const Rows& rows, PetscInt size) {
  if (size == 2)
    return std::make_unique<Kind<2>>(rows);
  if (size == 3)
    return std::make_unique<Kind<3>>(rows);
  return nullptr;
}

Rows rows_of(Mat matrix, PetscScalar* values) {
  Rows rows;
  PetscBool done = PETSC_FALSE;
  check(MatGetRowIJ(matrix, 0, PETSC_FALSE, PETSC_TRUE, &rows.count, &rows.begin, &rows.column, &done));
  rows.values = done ? values : nullptr;
  return rows;
}

/// Creates the threaded product of a matrix on one rank; returns null for a matrix of another type.
std::unique_ptr<Product> product_of(Mat matrix) {
  PetscBool symmetric = PETSC_FALSE, components = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(matrix), MATSEQSBAIJ, &symmetric));
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(matrix), MATSEQMAIJ, &components));
  if (!symmetric && !components)
    return nullptr;
  // The matrix keeps its arrays where they are for as long as it lives unchanged.
  const Mat stored = symmetric ? matrix : petsc::component(matrix);
  PetscScalar* values = nullptr;
  check(symmetric ? MatSeqSBAIJGetArray(stored, &values) : MatSeqAIJGetArray(stored, &values));
  const Rows rows = rows_of(stored, values);
  check(symmetric ? MatSeqSBAIJRestoreArray(stored, &values) : MatSeqAIJRestoreArray(stored, &values));
  PetscInt size = 1;
  check(MatGetBlockSize(matrix, &size));
  if (!rows.values)
    return nullptr;
  return symmetric ? product<SymmetricProduct>(rows, size) : product<ComponentProduct>(rows, size);
}

PetscErrorCode run(Mat matrix, Vec x, Vec z, Vec y) {
  PetscFunctionBeginUser;
  PetscContainer container = nullptr;
  void* own = nullptr;
  PetscCall(PetscObjectQuery(reinterpret_cast<PetscObject>(matrix), attached,
                             reinterpret_cast<PetscObject*>(&container)));
  PetscCheck(container, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "a copy of a matrix with threaded products cannot be multiplied");
  PetscCall(PetscContainerGetPointer(container, &own));
  const PetscScalar *from = nullptr, *added = nullptr;
  PetscScalar* to = nullptr;
  PetscCall(VecGetArrayRead(x, &from));
  if (z && z != y)
    PetscCall(VecGetArrayRead(z, &added));
  PetscCall(VecGetArray(y, &to));
  (*static_cast<Product*>(own))(from, z == y ? to : added, to);
  PetscCall(VecRestoreArray(y, &to));
  if (z && z != y)
    PetscCall(VecRestoreArrayRead(z, &added));
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode threaded_multiply(Mat matrix, Vec x, Vec y) { return run(matrix, x, nullptr, y); }

PetscErrorCode threaded_multiply_add(Mat matrix, Vec x, Vec z, Vec y) { return run(matrix, x, z, y); }

#if PETSC_VERSION_LT(3, 23, 0)
PetscErrorCode destroy(void* own) {
  delete static_cast<Product*>(own);
  return PETSC_SUCCESS;
}

PetscErrorCode set_destroy(PetscContainer container) {
  return PetscContainerSetUserDestroy(container, destroy);
}
#else
// Address of a pointer, by its type until PETSc 3.24 and as a void* since.
template <class Address>
PetscErrorCode destroy(Address address) {
  void*& own = *static_cast<void**>(address);
  delete static_cast<Product*>(own);
  own = nullptr;
  return PETSC_SUCCESS;
}

PetscErrorCode set_destroy(PetscContainer container) {
  return PetscContainerSetCtxDestroy(container, destroy);
}
#endif

} // namespace

void thread_products(Mat matrix) {
  PetscBool distributed = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(matrix), MATMPISBAIJ, &distributed));
  if (distributed)
    check(MatGetDiagonalBlock(matrix, &matrix));
  std::unique_ptr<Product> product = product_of(matrix);
  if (!product)
    return;
  PetscContainer container = nullptr;
  check(PetscContainerCreate(PETSC_COMM_SELF, &container));
  check(PetscContainerSetPointer(container, product.release()));
  check(set_destroy(container));
  check(PetscObjectCompose(reinterpret_cast<PetscObject>(matrix), attached,
                           reinterpret_cast<PetscObject>(container)));
  check(PetscContainerDestroy(&container));
  check(MatSetOperation(matrix, MATOP_MULT, reinterpret_cast<void (*)()>(threaded_multiply)));
  check(MatSetOperation(matrix, MATOP_MULT_ADD, reinterpret_cast<void (*)()>(threaded_multiply_add)));
}

petsc::Matrix symmetric_half(Mat blocks) {
  check(MatSetOption(blocks, MAT_SYMMETRIC, PETSC_TRUE)); // PETSc 3.25 needs the option, even for PᵀMP
  petsc::Matrix half;
  check(MatConvert(blocks, MATSBAIJ, MAT_INITIAL_MATRIX, half.put()));
  thread_products(half);
  return half;
}

} // namespace signorini
