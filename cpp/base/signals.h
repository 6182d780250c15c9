#pragma once
#include <mpi.h>

namespace signorini {

/// From now on SIGINT, SIGTERM and SIGUSR1 ask the run to stop at the next safe point instead of ending the
/// process; the same signal a second time ends it at once. Use SIGUSR1 with mpirun, which forwards it to its
/// ranks; at the others mpirun kills them.
void catch_stop_signals();

/// Whether any rank was asked to stop. Collective.
bool stop_requested(MPI_Comm comm);

} // namespace signorini
