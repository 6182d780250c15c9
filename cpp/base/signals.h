// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <csignal>
#include <mpi.h>

namespace signorini {

/// From now on SIGINT, SIGTERM and SIGUSR1 ask the run to stop at the next safe point instead of ending the
/// process; the same signal a second time ends it at once. Use SIGUSR1 with mpirun, which forwards it to its
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

/// From now on a pipe that nobody reads any more fails writes to it instead of ending the process.
void ignore_broken_pipes();

/// From `seconds` on (s, above 0) the run is asked to stop, too. Needs catch_stop_signals().
void stop_after(double seconds);
/// Whether that has come about on any rank. Collective.
bool time_is_up(MPI_Comm comm);
/// Takes that back, and a stop that it has asked for.
void forget_deadline();

/// Whether this process was asked to stop.
bool stop_requested();
/// Whether any rank was. Collective.
bool stop_requested(MPI_Comm comm);

} // namespace signorini
