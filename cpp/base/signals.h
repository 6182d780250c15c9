#pragma once
#include <mpi.h>

namespace signorini {

/// From now on SIGINT, SIGTERM and SIGUSR1 ask the run to stop at the next safe point instead of ending the process; a
/// second one of them ends it at once. SIGUSR1 is the one that mpirun passes on: at the others it kills its ranks.
void catch_stop_signals();

/// Whether any rank was asked to stop. Collective.
bool stop_requested(MPI_Comm comm);

} // namespace signorini
