// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <mpi.h>
#include <optional>

namespace signorini {

/// Sets the default number of OpenMP threads of this rank: `asked` if given, else the value of
/// OMP_NUM_THREADS. If neither is set, the ranks on this machine share its cores evenly, with at least one
/// thread each. The BLAS always uses one thread. Collective on `comm`.
void use_threads(MPI_Comm comm, std::optional<int> asked);

/// Number of OpenMP threads of this rank.
int threads();

/// Processor time of this thread plus that of the programs that this process has run to their end (the
/// meshing program), s. It hardly depends on other programs on the machine. Waiting for threads and ranks
/// counts as processor time.
double processor_seconds();

/// Peak resident memory of this process since its start or since the last forget_peak_memory(), bytes.
double peak_memory();

/// Resident memory that this process has now, bytes; 0 on systems that do not report it (Linux does).
double resident_memory();

/// Returns free heap memory to the system and resets the value of peak_memory() to the present resident
/// memory. On systems other than Linux the peak is not reset.
void forget_peak_memory();

/// Physical memory of the machine, bytes.
double machine_memory();

} // namespace signorini
