// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <mpi.h>

namespace signorini {

/// What all ranks together do in a second while all of them work.
struct MachineRates {
  double flops; ///< of dense products, on one thread of each rank
  double bytes; ///< read from an array, on all threads
};

/// Measures dense products and reads of as many bytes as `bytes` asks for on all ranks together, within
/// limits beyond which rates change no more; takes about a tenth of a second. Collective; the same on every
/// rank.
MachineRates measure_rates(MPI_Comm comm, double bytes);

} // namespace signorini
