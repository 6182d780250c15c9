// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <mpi.h>
#include <optional>

namespace signorini {

/// Sets on how many threads this rank works from now on (OpenMP's default): as many as asked for, else as
/// OMP_NUM_THREADS says, else as many as the ranks on this machine leave each other of the cores that they
/// may use, one at least. Collective on `comm`.
void use_threads(MPI_Comm comm, std::optional<int> asked);

/// That number.
int threads();

} // namespace signorini
