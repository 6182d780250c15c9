// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <petscmat.h>

namespace signorini {

/// Makes products with a matrix on one rank, plain and added to a vector, run on the threads of OpenMP from
/// now on. The matrix is SBAIJ in blocks of 2 or 3, or MAIJ of as many components; others keep PETSc's
/// products, as do small matrices. The rows are divided by the matrix alone, so products are the same to the
/// last bit on any number of threads. Copies of the matrix must not be multiplied. Not collective.
void thread_products(Mat matrix);

} // namespace signorini
