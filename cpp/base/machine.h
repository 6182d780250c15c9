// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <mpi.h>
#include <optional>

namespace signorini {

/// Sets the number of threads of this rank (OpenMP's default): `asked`, else OMP_NUM_THREADS, else its share
/// of the cores that the ranks on this machine may use, one at least. Collective on `comm`.
void use_threads(MPI_Comm comm, std::optional<int> asked);

/// The number of threads in use.
int threads();

/// Processor time of this thread and of the programs that this process has run (the meshing program), s.
/// Other programs on the machine hardly change it; waiting for threads and ranks counts.
double processor_seconds();

/// Peak resident memory of this process since its start or the last forget_peak_memory(), bytes.
double peak_memory();

/// Resident memory of this process now, bytes; 0 where the system does not report it (Linux does).
double resident_memory();

/// Resets the peak to the present resident memory where the system allows it (Linux); first returns free heap
/// memory to the system.
void forget_peak_memory();

/// Physical memory of the machine, bytes.
double machine_memory();

} // namespace signorini
