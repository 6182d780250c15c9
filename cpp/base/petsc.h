// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <petscsnes.h>
#include <source_location>
#include <span>
#include <utility>
#include <vector>

/// Owning wrappers and helpers for PETSc objects.
namespace signorini::petsc {

/// Throws std::bad_alloc if the error code `ierr` means that memory ran out, and SolverFailure with PETSc's
/// message for any other error.
void check(PetscErrorCode ierr, std::source_location where = std::source_location::current());

/// Makes PETSc store its error messages for check() instead of printing a traceback.
void keep_error_messages();

/// Sole owner of one PETSc object; converts implicitly to the PETSc handle.
template <class T, PetscErrorCode (*destroy)(T*)>
class Handle {
public:
  Handle() = default;
  explicit Handle(T object) : object_(object) {}
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Handle() { destroy(&object_); }

  operator T() const { return object_; }

  /// Returns the address that a PETSc function which creates an object writes to; first destroys the object
  /// owned so far.
  T* put() {
    destroy(&object_);
    return &object_;
  }

private:
  T object_ = nullptr;
};

using Vector = Handle<Vec, VecDestroy>;
using Matrix = Handle<Mat, MatDestroy>;
using LinearSolver = Handle<KSP, KSPDestroy>;
using Preconditioner = Handle<PC, PCDestroy>;
using NonlinearSolver = Handle<SNES, SNESDestroy>;
using NullSpace = Handle<MatNullSpace, MatNullSpaceDestroy>;
using IndexSet = Handle<IS, ISDestroy>;

/// Creates a vector with the layout of `x` and zero entries. Collective.
Vector zero_like(Vec x);

/// Creates a copy of `x`. Collective.
Vector copy(Vec x);

/// Creates a zero vector by which `matrix` can be multiplied: it has the layout of the matrix's columns.
/// Collective.
Vector vector_of(Mat matrix);

/// Sets out = a x + b y, whatever `out` contained (even NaN); `out` must be neither x nor y. Collective.
void combine(Vec out, double a, Vec x, double b, Vec y);

/// Vectors of a time series, one per time step.
using Series = std::vector<Vector>;

/// Creates `count` zero vectors with the layout of `x`. Collective.
Series zero_series(Vec x, std::size_t count);

/// Scope guard that gives access to this rank's entries of a vector.
template <class T, PetscErrorCode (*take)(Vec, T**), PetscErrorCode (*give_back)(Vec, T**)>
class Array {
public:
  explicit Array(Vec x) : x_(x) {
    PetscInt n = 0;
    check(VecGetLocalSize(x, &n));
    check(take(x, &data_));
    size_ = static_cast<std::size_t>(n);
  }
  ~Array() { (void)give_back(x_, &data_); }
  Array(const Array&) = delete;
  Array& operator=(const Array&) = delete;
  operator std::span<T>() const { return {data_, size_}; }
  T& operator[](std::size_t i) const { return std::span(data_, size_)[i]; }
  [[nodiscard]] std::size_t size() const { return size_; }

private:
  Vec x_;
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

using ReadArray = Array<const PetscScalar, VecGetArrayRead, VecRestoreArrayRead>;
using WriteArray = Array<PetscScalar, VecGetArray, VecRestoreArray>;

/// Scope guard that makes a vector use an array of this rank as its entries (VecPlaceArray). The destructor
/// restores the vector's original entries, unchanged.
class Placed {
public:
  /// `array` has one entry for each entry of x that this rank owns and must outlive this object. Write
  /// through x only if the array itself is not const.
  Placed(Vec x, std::span<const double> array) : x_(x) { check(VecPlaceArray(x, array.data())); }
  ~Placed() { (void)VecResetArray(x_); }
  Placed(const Placed&) = delete;
  Placed& operator=(const Placed&) = delete;
  operator Vec() const { return x_; }

private:
  Vec x_;
};

/// Scope guard that borrows a column of a dense matrix as a vector, for reading only. Collective.
class Column {
public:
  Column(Mat matrix, PetscInt j) : matrix_(matrix), j_(j) {
    check(MatDenseGetColumnVecRead(matrix, j, &column_));
  }
  ~Column() { (void)MatDenseRestoreColumnVecRead(matrix_, j_, &column_); }
  Column(const Column&) = delete;
  Column& operator=(const Column&) = delete;
  operator Vec() const { return column_; }

private:
  Mat matrix_;
  PetscInt j_;
  Vec column_ = nullptr;
};

/// Returns the scalar matrix that a MAIJ matrix applies to each component, or null for other types. The
/// caller must not destroy it.
Mat component(Mat matrix);

/// Memory of the stored entries and indices of a sparse matrix, summed over all ranks, bytes. Collective.
double bytes(Mat matrix);

/// Inner product x·y. Collective.
double dot(Vec x, Vec y);

/// Sum of inner products x·y, together with the sum of their bounds ‖x‖ ‖y‖. `size` is the scale of the
/// rounding error of `value`, even where terms cancel.
struct Pairing {
  double value = 0, size = 0;

  /// Adds x·y. Collective.
  void add(Vec x, Vec y);
  /// |other − value| / size, where `other` is the same sum computed in another way; 0 if both are equal.
  [[nodiscard]] double defect(double other) const;
};

/// MPI communicator of a PETSc object. Not collective.
MPI_Comm comm(PetscObject object);
inline MPI_Comm comm(Vec x) { return comm(reinterpret_cast<PetscObject>(x)); }
inline MPI_Comm comm(Mat x) { return comm(reinterpret_cast<PetscObject>(x)); }

/// Sets the PETSc option `-name_key` to `value` unless the user has set this option.
void default_option(const char* name, const char* key, const char* value);

} // namespace signorini::petsc
