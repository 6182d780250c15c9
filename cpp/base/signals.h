// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <csignal>
#include <mpi.h>

namespace signorini {

/// Makes SIGINT, SIGTERM and SIGUSR1 request a stop of the run at the next safe point instead of ending the
/// process. The same signal a second time ends it at once. Use SIGUSR1 with mpirun, which forwards it to its
/// ranks; at the others mpirun kills them.
void catch_stop_signals();

/// Scope guard for a library within a program that has signal handlers of its own: SIGINT requests a stop,
/// however often it comes; the destructor restores the previous handler. One at a time.
class StopOnInterrupt {
public:
  StopOnInterrupt();
  ~StopOnInterrupt() { (void)release(); }
  /// Restores the previous handler. Returns whether a stop was requested, and clears the request.
  bool release();
  StopOnInterrupt(const StopOnInterrupt&) = delete;
  StopOnInterrupt& operator=(const StopOnInterrupt&) = delete;

private:
  struct sigaction before_{};
  bool released_ = false;
};

/// Requests a stop, as the signals do.
void request_stop();

/// Makes writes to a closed pipe fail instead of ending the process.
void ignore_broken_pipes();

/// Requests a stop of the run `seconds` from now (s, above 0).
void stop_after(double seconds);
/// Whether the time of stop_after() is over on any rank. Collective.
bool time_is_up(MPI_Comm comm);
/// Cancels stop_after(), and the stop that it has requested.
void forget_deadline();

/// Whether a stop of this process was requested.
bool stop_requested();
/// Whether a stop was requested on any rank. Collective.
bool stop_requested(MPI_Comm comm);

} // namespace signorini
