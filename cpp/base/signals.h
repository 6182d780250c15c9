#pragma once
#include <mpi.h>

namespace signorini {

/// From now on SIGINT and SIGTERM ask the run to stop at the next safe point instead of ending the process;
/// a second signal ends it at once.
void catch_stop_signals();

/// Whether any rank was asked to stop. Collective.
bool stop_requested(MPI_Comm comm);

} // namespace signorini
