// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <petscsnes.h>
#include <source_location>
#include <span>
#include <utility>
#include <vector>

/// Owning wrappers and helpers for PETSc objects.
namespace signorini::petsc {

/// Throws SolverFailure with PETSc's own message if `ierr` is an error, std::bad_alloc if memory ran out.
void check(PetscErrorCode ierr, std::source_location where = std::source_location::current());

/// Makes PETSc keep its error messages for check() instead of printing a traceback.
void keep_error_messages();

/// Sole owner of one PETSc object; converts to the PETSc handle wherever one is expected.
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

  /// Address for a PETSc function that creates an object; destroys the object owned before.
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

/// A vector of the same layout, entries zero. Collective.
Vector zero_like(Vec x);

/// A vector of the same layout and entries. Collective.
Vector copy(Vec x);

/// A zero vector x of the layout for products matrix x (the columns'). Collective.
Vector vector_of(Mat matrix);

/// Sets out = a x + b y, whatever its values; `out` is neither x nor y. Collective.
void combine(Vec out, double a, Vec x, double b, Vec y);

/// A series of vectors, one per time step.
using Series = std::vector<Vector>;

/// `count` zero vectors of the layout of `x`. Collective.
Series zero_series(Vec x, std::size_t count);

/// Access to this rank's entries of a vector during this object's lifetime.
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

/// Makes a vector use an array of this rank as its entries during this object's lifetime (VecPlaceArray); its
/// own entries are unchanged afterwards.
class Placed {
public:
  /// `array`: as many entries as this rank owns of x; it must outlive this object. Writing through x is
  /// allowed only if the array itself is not const.
  Placed(Vec x, std::span<const double> array) : x_(x) { check(VecPlaceArray(x, array.data())); }
  ~Placed() { (void)VecResetArray(x_); }
  Placed(const Placed&) = delete;
  Placed& operator=(const Placed&) = delete;
  operator Vec() const { return x_; }

private:
  Vec x_;
};

/// A column of a dense matrix as a vector to be read, borrowed during this object's lifetime. Collective.
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

/// The scalar matrix that a matrix of type MAIJ applies to each component, borrowed; null for other types.
Mat component(Mat matrix);

/// Memory of the entries and indices of a sparse matrix on all ranks, bytes. Collective.
double bytes(Mat matrix);

/// x·y. Collective.
double dot(Vec x, Vec y);

/// A sum of products x·y with the sum of their bounds ‖x‖ ‖y‖, the scale of its rounding error where terms
/// cancel.
struct Pairing {
  double value = 0, size = 0;

  /// Adds x·y. Collective.
  void add(Vec x, Vec y);
  /// Distance of `other`, the same sum computed differently, from the value, in units of the size.
  [[nodiscard]] double defect(double other) const;
};

/// The MPI communicator of a PETSc object. Not collective.
MPI_Comm comm(PetscObject object);
inline MPI_Comm comm(Vec x) { return comm(reinterpret_cast<PetscObject>(x)); }
inline MPI_Comm comm(Mat x) { return comm(reinterpret_cast<PetscObject>(x)); }

/// Sets the option `-name_key value` of the solver with the prefix `name_` unless the user has set it.
void default_option(const char* name, const char* key, const char* value);

} // namespace signorini::petsc
