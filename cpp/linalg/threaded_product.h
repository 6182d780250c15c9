// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"

namespace signorini {

/// Makes later products with a matrix (MatMult, MatMultAdd) run on the threads of OpenMP. `matrix`: SBAIJ
/// with blocks of 2 or 3, or on one rank MAIJ with 2 or 3 components. On several ranks only the block of the
/// rank's own rows and columns takes threads. Matrices of other types keep PETSc's products. A product with a
/// small matrix takes one thread. It is quicker than PETSc's product, which prefetches blocks past the
/// caches. How rows are divided depends on the matrix alone, so that products are bitwise equal for any
/// number of threads. Do not multiply copies that PETSc makes of the matrix (MatDuplicate): their products
/// fail. Not collective.
void thread_products(Mat matrix);

/// Returns the upper half (SBAIJ) of a symmetric matrix of blocks (BAIJ), with thread_products(). Collective.
petsc::Matrix symmetric_half(Mat blocks);

} // namespace signorini
