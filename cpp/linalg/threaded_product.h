// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <petscmat.h>

namespace signorini {

/// Makes later products with a matrix (MatMult, MatMultAdd) run on the threads of OpenMP. `matrix`: on one
/// rank, SBAIJ with blocks of 2 or 3, or MAIJ with 2 or 3 components. Matrices of other types and small
/// matrices keep PETSc's products. How rows are divided depends on the matrix alone, so that products are
/// bitwise equal for any number of threads. Do not multiply copies that PETSc makes of the matrix
/// (MatDuplicate): their products fail. Not collective.
void thread_products(Mat matrix);

} // namespace signorini
